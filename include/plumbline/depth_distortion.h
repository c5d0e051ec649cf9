// The distortion of a camera's depth: a smooth error of its inverse depth that is the same in every frame.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "plumbline/export.h"
#include "plumbline/image.h"

namespace plumbline {

/// Structured light and stereo measure a disparity, proportional to 1/z. Every such sensor is off by a smooth pattern
/// of its own (Herrera, Kannala, Heikkilä, "Joint depth and color camera calibration with distortion correction", PAMI
/// 2012; Teichman, Miller, Thrun, "Unsupervised intrinsic calibration of depth sensors via SLAM", RSS 2013): a few
/// tenths of a pixel, which are centimetres at 2 m. Here it is a grid of nodes over the image; between them it follows
/// by cubic convolution (Keys, "Cubic convolution interpolation for digital image processing", 1981), because a slope
/// that jumps from cell to cell turns the camera.
class PLUMBLINE_EXPORT DepthDistortion {
 public:
  static constexpr int kColumns = 11;  ///< nodes from left to right; as many from top to bottom as are as dense

  DepthDistortion() = default;
  /// None yet, for undistorted images of width × height pixels, both at least 2. There are at least four rows of nodes.
  DepthDistortion(int width, int height);

  bool empty() const { return values_.empty(); }
  int width() const { return width_; }
  int height() const { return height_; }
  int rows() const { return rows_; }
  /// 1/m, what is measured less what is true; row by row.
  const std::vector<double>& values() const { return values_; }
  std::vector<double>& values() { return values_; }
  double rms() const;
  /// "a distortion of the depth of 3.8 cm rms at 2 m"
  std::string describe() const;

  /// The nodes about a pixel, four by four, and their shares, which add up to 1.
  struct Nodes {
    std::size_t first;  ///< index of the upper left one
    std::array<double, 16> share;

    /// Of the row's first node.
    std::size_t row(std::size_t r) const { return first + r * kColumns; }
    /// Of the node whose share is the i-th.
    std::size_t index(std::size_t i) const { return row(i / 4) + i % 4; }
  };
  Nodes nodes(double x, double y) const;
  double at(const Nodes& n) const;
  double at(double x, double y) const { return at(nodes(x, y)); }

  /// Throws Error for images of another size.
  void check_size(int width, int height) const;
  /// Takes it out of an image of that size. A reading that would lie at no positive depth becomes none. Throws Error
  /// for an image of another size.
  void correct(double readings_per_metre, DepthImage* depth) const;

 private:
  int width_ = 0, height_ = 0, rows_ = 0;
  double step_ = 1;  ///< pixels from node to node
  std::vector<double> values_;
};

}  // namespace plumbline
