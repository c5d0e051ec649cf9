#include "io/formats/formats.h"

#include <array>

namespace plumbline {

std::span<const FolderFormat> folder_formats() {
  static constexpr std::array kFormats = {
      FolderFormat{"StrayScanner", "camera_matrix.csv and depth/", list_stray_scanner},
      FolderFormat{"Record3D", "metadata.json and depth/0.exr", list_record3d},
      FolderFormat{"3D Scanner App", "depth_00000.png and frame_00000.json", list_scanner_app},
      FolderFormat{"Polycam", "keyframes/ with cameras/ and depth/", list_polycam},
      FolderFormat{"OpenLORIS-Scene", "sensors.yaml and aligned_depth.txt", list_open_loris},
      FolderFormat{"Replica", "results/depth000000.png and traj.txt", list_replica},
      FolderFormat{"TUM RGB-D, ICL-NUIM", "depth.txt or associations.txt", list_tum_or_icl},
      FolderFormat{"7-Scenes", "frame-000000.depth.png", list_seven_scenes},
      FolderFormat{"NYU Depth", "d-STAMP-TICKS.pgm", list_nyu},
      FolderFormat{"depth images", "16-bit depth images", list_depth_images},
  };
  return kFormats;
}

}  // namespace plumbline
