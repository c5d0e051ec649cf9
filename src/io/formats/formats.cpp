#include "io/formats/formats.h"

#include <array>

namespace plumbline {

std::span<const FolderFormat> folder_formats() {
  static constexpr std::array kFormats = {
      FolderFormat{"StrayScanner", "camera_matrix.csv and depth/", list_stray_scanner},
      FolderFormat{"Replica", "results/depth000000.png and traj.txt", list_replica},
      FolderFormat{"TUM RGB-D, ICL-NUIM", "depth.txt or associations.txt", list_tum_or_icl},
      FolderFormat{"7-Scenes", "frame-000000.depth.png", list_seven_scenes},
      FolderFormat{"depth images", "16-bit depth images", list_depth_images},
  };
  return kFormats;
}

}  // namespace plumbline
