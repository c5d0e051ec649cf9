// The reconstructed surface.
#pragma once

#include <cstdint>
#include <vector>

namespace plumbline {

/// Indexed triangle mesh in metres, world frame. `normals` and `colors` are empty or one per vertex; triangles wind
/// counter-clockwise seen from outside (the free side).
struct Mesh {
  struct Float3 {
    float x, y, z;
  };
  struct Rgb {
    std::uint8_t r, g, b;
  };
  struct Triangle {
    std::uint32_t a, b, c;
  };
  std::vector<Float3> positions, normals;
  std::vector<Rgb> colors;
  std::vector<Triangle> triangles;
};

}  // namespace plumbline
