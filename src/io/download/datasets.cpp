#include "io/datasets.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "io/camera.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

constexpr const char* kTum = "https://cvg.cit.tum.de/rgbd/dataset";
constexpr const char* kIcl = "https://www.doc.ic.ac.uk/~ahanda";

constexpr std::array kFreiburg1 = {"xyz", "rpy", "360", "floor", "desk", "desk2", "room", "plant", "teddy"};
constexpr std::array kFreiburg2 = {"xyz",
                                   "rpy",
                                   "360_hemisphere",
                                   "360_kidnap",
                                   "desk",
                                   "large_no_loop",
                                   "large_with_loop",
                                   "pioneer_360",
                                   "pioneer_slam",
                                   "pioneer_slam2",
                                   "pioneer_slam3",
                                   "coke",
                                   "dishes",
                                   "flowerbouquet",
                                   "flowerbouquet_brownbackground",
                                   "metallic_sphere",
                                   "metallic_sphere2",
                                   "desk_with_person"};
constexpr std::array kFreiburg3 = {"long_office_household",
                                   "nostructure_notexture_far",
                                   "nostructure_notexture_near_withloop",
                                   "nostructure_texture_far",
                                   "nostructure_texture_near_withloop",
                                   "structure_notexture_far",
                                   "structure_notexture_near",
                                   "structure_texture_far",
                                   "structure_texture_near",
                                   "sitting_static",
                                   "sitting_xyz",
                                   "sitting_halfsphere",
                                   "sitting_rpy",
                                   "walking_static",
                                   "walking_xyz",
                                   "walking_halfsphere",
                                   "walking_rpy",
                                   "cabinet",
                                   "large_cabinet",
                                   "teddy"};

template <class Names>
void add_tum(int camera, const Names& names, std::vector<Dataset>* all) {
  for (const char* name : names) {
    const std::string folder = fmt::format("rgbd_dataset_freiburg{}_{}", camera, name);
    all->push_back(
        {fmt::format("fr{}/{}", camera, name), folder, fmt::format("{}/freiburg{}/{}.tgz", kTum, camera, folder), ""});
  }
}

std::vector<Dataset> make_list() {
  std::vector<Dataset> all;
  add_tum(1, kFreiburg1, &all);
  add_tum(2, kFreiburg2, &all);
  add_tum(3, kFreiburg3, &all);
  for (const auto& [room, prefix] : {std::pair("living_room", "living_room_"), {"office", ""}})
    for (int k = 0; k < 4; ++k)
      for (const char* noise : {"", "n"})
        all.push_back({fmt::format("icl/{}_kt{}{}", room, k, noise), fmt::format("icl_nuim_{}_kt{}{}", room, k, noise),
                       fmt::format("{}/{}traj{}{}_frei_png.tar.gz", kIcl, prefix, k, noise), ""});
  return all;
}

}  // namespace

const std::vector<Dataset>& datasets() {
  static const std::vector<Dataset> list = make_list();
  return list;
}

Dataset find_dataset(std::string_view name) {
  std::string wanted = lower(name);
  if (wanted.starts_with("freiburg")) wanted.replace(0, 8, "fr");
  std::string near;
  for (const Dataset& dataset : datasets()) {
    if (dataset.name == wanted || dataset.folder == wanted) return dataset;
    if (wanted.size() > 2 && dataset.name.find(wanted) != std::string::npos)
      near += (near.empty() ? "" : ", ") + dataset.name;
  }
  throw Error(fmt::format("there is no data set named '{}'", name), "download",
              near.empty() ? "list the names with `plumbline download --list`" : "perhaps you mean " + near);
}

}  // namespace plumbline
