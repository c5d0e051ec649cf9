// The images of one frame and of the model's prediction, level by level, in a backend's memory.
#pragma once

#include <vector>

#include "backend/backend.h"
#include "core/plane.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"

namespace plumbline {

/// Depth in metres along the optical axis and unit normals towards the camera, in its frame; zeros where there is none.
/// Vertices are not stored: they follow from the depth and the camera.
struct DepthLevel {
  Pinhole camera;
  Plane<float> depth, normal_x, normal_y, normal_z;
  Plane<float> inverse_depth;   ///< scratch of `estimate_plane_normals`; costs nothing before
  Plane<float> pair_distances;  ///< scratch of a registration of this level with the median filter; likewise

  DepthLevel(const Pinhole& level_camera, const Backend& backend);
  kernels::NormalPlanes normals() const { return {normal_x.view(), normal_y.view(), normal_z.view()}; }
};

/// Finest level first.
using DepthPyramid = std::vector<DepthLevel>;
/// `levels` levels of a camera's pyramid, from `finest_level` on.
DepthPyramid make_pyramid(const Pinhole& camera, int levels, const Backend& backend, int finest_level = 0);

template <class T>
PlaneView<const T> read_only(const Plane<T>& plane) {
  const PlaneView<T> view = plane.view();
  return {view.data, view.width, view.height, view.stride};
}

/// A plane's pixels as a host image, without padding.
template <class T>
Image<T> download(const Backend& backend, const Plane<T>& plane) {
  const PlaneView<T> view = plane.view();
  const std::vector<T> padded = plane.elements().download(backend);
  Image<T> image(view.width, view.height);
  for (int y = 0; y < view.height; ++y) {
    const T* row = padded.data() + static_cast<std::ptrdiff_t>(y) * view.stride + Plane<T>::kPadding;
    std::copy(row, row + view.width, image.row(y));
  }
  return image;
}

/// A host image into a plane of the same size.
template <class T>
void upload(const Backend& backend, const Image<T>& image, Plane<T>& plane) {
  const PlaneView<T> view = plane.view();
  const std::size_t row_bytes = sizeof(T) * static_cast<std::size_t>(view.width);
  backend.upload_rows(view.data, sizeof(T) * static_cast<std::size_t>(view.stride), image.row(0), row_bytes, row_bytes,
                      view.height);
}

/// Normals of a level's depth by a plane fit over a window of `radius` px to each side; `depth_gate` is the fraction of
/// depth within which a neighbour belongs to the surface.
void estimate_plane_normals(const Backend& backend, DepthLevel& level, int radius, float depth_gate);

/// The registration kernel's input for one level of a live and a predicted pyramid; the gates are left to the caller.
kernels::IcpInput icp_input(const DepthLevel& live, const DepthLevel& model);

}  // namespace plumbline
