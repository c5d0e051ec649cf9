#include "io/imu/imu_columns.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include "io/camera.h"

namespace plumbline {
namespace {

/// Units that stand behind a name without brackets, as in gyro_x_dps.
constexpr std::array<std::string_view, 14> kUnitEndings = {"_rad/s", "_deg/s", "_rad_s", "_deg_s", "_rads",
                                                           "_degs",  "_dps",   "_m/s2",  "_m_s2",  "_mps2",
                                                           "_ms2",   "_mg",    "_g",     "_ut"};
}  // namespace

std::optional<std::pair<ImuSensor, int>> component_of(const std::string& name) {
  if (name.empty() || name.back() < 'x' || name.back() > 'z') return std::nullopt;
  std::string stem;
  for (const char c : std::string_view(name).substr(0, name.size() - 1))
    if (c != '_' && c != '.' && c != '/' && c != '-' && c != ' ') stem += c;
  const auto has = [&](std::string_view part) { return stem.find(part) != std::string::npos; };
  const int axis = name.back() - 'x';
  if (has("bias") || has("cov")) return std::nullopt;
  if (has("user") || has("gravity")) return std::nullopt;  // what phones make of their accelerometer's readings
  if (has("gyr") || has("angularvel") || has("angularrate") || has("angvel") || has("angrate") || has("rotationrate") ||
      has("rotrate") || has("turnrate") || stem == "rate" || has("omega") || stem == "g" || stem == "alpha" ||
      stem == "w" || stem == "wrss")
    return std::pair(kGyroscope, axis);
  if (has("acc") || has("specificforce") || stem == "a" || stem == "arss") return std::pair(kAccelerometer, axis);
  if (has("mag") || stem == "m") return std::pair(kMagnetometer, axis);
  return std::nullopt;
}

ColumnName with_unit_apart(ColumnName column) {
  for (const std::string_view ending : kUnitEndings) {
    if (!column.unit.empty() || column.name.size() <= ending.size() || !column.name.ends_with(ending)) continue;
    ColumnName apart{column.name.substr(0, column.name.size() - ending.size()), std::string(ending.substr(1))};
    std::replace(apart.unit.begin(), apart.unit.end(), '_', '/');
    if (component_of(apart.name)) return apart;
  }
  return column;
}

std::vector<ColumnName> named_by_file(std::vector<ColumnName> names, const std::string& path) {
  const std::string file = lower(std::filesystem::path(path).filename().string());
  const char* sensor = file.find("gyr") != std::string::npos   ? "gyro_"
                       : file.find("acc") != std::string::npos ? "acc_"
                                                               : nullptr;
  const auto is_bare = [](const ColumnName& c) { return c.name == "x" || c.name == "y" || c.name == "z"; };
  if (sensor == nullptr || std::count_if(names.begin(), names.end(), is_bare) != 3) return names;
  for (ColumnName& column : names)
    if (is_bare(column)) column.name = sensor + column.name;
  return names;
}

}  // namespace plumbline
