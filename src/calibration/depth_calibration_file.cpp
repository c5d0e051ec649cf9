#include <fmt/format.h>

#include "io/atomic_file.h"
#include "io/calibration_file.h"
#include "plumbline/calibration.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

constexpr double kSmallestImage = 16, kLargestImage = 16384;  // pixels
constexpr double kLargestError = 1;                           // 1/m

int image_size(const CalibrationFile& file, const std::string& path, const char* key) {
  const double value = file.numbers(key, 1, kLargestImage)[0];
  if (value < kSmallestImage) throw Error(fmt::format("{} is too small", key), path, CalibrationFile::kAdvice);
  return static_cast<int>(value);
}

}  // namespace

void write_depth_calibration(const std::string& path, const DepthDistortion& distortion,
                             const std::vector<std::string>& comments) {
  std::string text;
  for (const std::string& comment : comments) text += "# " + comment + "\n";
  text += fmt::format(
      "\n[image]\nwidth = {}\nheight = {}\n\n[depth]\n# 1/m, measured less true, at nodes from left to right and top "
      "to bottom; cubic convolution between them\ninverse_error = [\n",
      distortion.width(), distortion.height());
  const std::vector<double>& values = distortion.values();
  for (auto row = values.begin(); row < values.end(); row += DepthDistortion::kColumns)
    text += fmt::format("  {:.6f},\n", fmt::join(row, row + DepthDistortion::kColumns, ", "));
  write_file(path, text + "]\n");
}

std::vector<std::string> depth_calibration_comments(const DepthCalibrationResult& found,
                                                    const std::string& command_line) {
  return {"The distortion of a camera's depth, for `--depth-calibration FILE`. Made by", command_line,
          fmt::format("from {} pairs of frames; they disagree by {:.4f}/m before, {:.4f}/m after.", found.pairs,
                      found.before, found.after)};
}

DepthDistortion read_depth_calibration(const std::string& path) {
  const CalibrationFile file(path);
  DepthDistortion distortion(image_size(file, path, "image.width"), image_size(file, path, "image.height"));
  distortion.values() = file.numbers("depth.inverse_error", distortion.values().size(), kLargestError);
  return distortion;
}

}  // namespace plumbline
