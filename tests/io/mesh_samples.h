// A mesh that is told apart from its mirror images and permutations.
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "plumbline/mesh.h"

namespace plumbline::test {

/// A strip of 2·n − 2 triangles; every vertex has another position, normal and colour.
inline Mesh make_strip(int n, bool normals, bool colors) {
  Mesh mesh;
  for (int i = 0; i < 2 * n; ++i) {
    const float a = 0.37f * static_cast<float>(i);
    mesh.positions.push_back({static_cast<float>(i / 2) * 0.01f, static_cast<float>(i % 2), std::sin(a)});
    if (normals) mesh.normals.push_back({std::cos(a), std::sin(a), 0});
    if (colors)
      mesh.colors.push_back({static_cast<std::uint8_t>(i * 7), static_cast<std::uint8_t>(i * 13 + 1),
                             static_cast<std::uint8_t>(255 - i)});
  }
  for (std::uint32_t i = 0; i + 2 < static_cast<std::uint32_t>(2 * n); ++i)
    mesh.triangles.push_back(i % 2 == 0 ? Mesh::Triangle{i, i + 1, i + 2} : Mesh::Triangle{i + 1, i, i + 2});
  return mesh;
}

inline void expect_equal(const Mesh::Float3& a, const Mesh::Float3& b) {
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.y, b.y);
  EXPECT_EQ(a.z, b.z);
}

inline void expect_equal(const Mesh& a, const Mesh& b) {
  ASSERT_EQ(a.positions.size(), b.positions.size());
  ASSERT_EQ(a.normals.size(), b.normals.size());
  ASSERT_EQ(a.colors.size(), b.colors.size());
  ASSERT_EQ(a.triangles.size(), b.triangles.size());
  for (std::size_t i = 0; i < a.positions.size(); ++i) expect_equal(a.positions[i], b.positions[i]);
  for (std::size_t i = 0; i < a.normals.size(); ++i) expect_equal(a.normals[i], b.normals[i]);
  for (std::size_t i = 0; i < a.colors.size(); ++i) {
    EXPECT_EQ(a.colors[i].r, b.colors[i].r);
    EXPECT_EQ(a.colors[i].g, b.colors[i].g);
    EXPECT_EQ(a.colors[i].b, b.colors[i].b);
  }
  for (std::size_t i = 0; i < a.triangles.size(); ++i) {
    EXPECT_EQ(a.triangles[i].a, b.triangles[i].a);
    EXPECT_EQ(a.triangles[i].b, b.triangles[i].b);
    EXPECT_EQ(a.triangles[i].c, b.triangles[i].c);
  }
}

}  // namespace plumbline::test
