// Public data sets by short names, and where their makers offer them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline {

struct Dataset {
  std::string name;    ///< "fr1/xyz", "icl/office_kt3"
  std::string folder;  ///< that it is unpacked to
  std::string url;     ///< of an archive (.tgz)
  std::string sha256;  ///< of the archive, in hexadecimal; empty where it is not known
};

/// TUM RGB-D (Sturm et al. 2012) and ICL-NUIM (Handa et al. 2014).
const std::vector<Dataset>& datasets();

/// By its short name, or by its folder's. Throws Error that names those that are near, or tells how to list them.
Dataset find_dataset(std::string_view name);

}  // namespace plumbline
