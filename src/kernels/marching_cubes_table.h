// The triangles of marching cubes (Lorensen and Cline 1987), derived instead of copied: for each of the 256 sign
// patterns the surface's outline is drawn on the six faces and its loops are cut into fans. On a face with two
// diagonal corners inside, each is cut off on its own; as that depends on the face alone, neighbouring cells agree and
// the mesh has no cracks (the ambiguity of Dürst 1988).
#pragma once

#include <array>
#include <cstdint>

namespace plumbline::kernels {

/// Corner c of a cell has offsets (c & 1, c >> 1 & 1, c >> 2). Edge 4·axis + k runs along `axis` from its lower corner.
constexpr int kCellEdges = 12;
constexpr int kMaxTriangles = 5;

/// Lower corner of an edge.
constexpr int edge_corner(int edge) {
  const int axis = edge / 4, k = edge % 4;
  const int p = k & 1, q = k >> 1;
  if (axis == 0) return p << 1 | q << 2;
  if (axis == 1) return p | q << 2;
  return p | q << 1;
}

struct CellTriangles {
  std::int8_t count = 0;
  std::array<std::int8_t, 3 * kMaxTriangles> edges{};
};

namespace detail {

/// Edge between two corners that differ in one bit.
constexpr int edge_between(int a, int b) {
  for (int edge = 0; edge < kCellEdges; ++edge) {
    const int low = edge_corner(edge), high = low | 1 << (edge / 4);
    if ((a == low && b == high) || (a == high && b == low)) return edge;
  }
  return -1;
}

/// The corners of face 2·axis + side, counter-clockwise seen from outside the cell.
constexpr std::array<int, 4> face_corners(int face) {
  const int axis = face / 2, side = face % 2;
  const int p = (axis + 1) % 3, q = (axis + 2) % 3;
  const int base = side << axis;
  if (side == 1) return {base, base | 1 << p, base | 1 << p | 1 << q, base | 1 << q};
  return {base, base | 1 << q, base | 1 << p | 1 << q, base | 1 << p};
}

/// For each crossed edge the next one along the surface's outline. `inside` has a bit for every corner below zero.
constexpr std::array<int, kCellEdges> outline(int inside) {
  std::array<int, kCellEdges> next{};
  for (int& e : next) e = -1;
  for (int face = 0; face < 6; ++face) {
    const std::array<int, 4> corner = face_corners(face);
    const auto is_inside = [&](int i) { return (inside >> corner[static_cast<std::size_t>(i % 4)] & 1) != 0; };
    const auto edge_after = [&](int i) {
      return edge_between(corner[static_cast<std::size_t>(i % 4)], corner[static_cast<std::size_t>((i + 1) % 4)]);
    };
    for (int i = 0; i < 4; ++i) {
      if (is_inside(i) || !is_inside(i + 1)) continue;  // a run of inside corners starts at i + 1
      int last = i + 1;
      while (is_inside(last + 1)) ++last;
      next[static_cast<std::size_t>(edge_after(i))] = edge_after(last);
    }
  }
  return next;
}

constexpr CellTriangles triangulate(int inside) {
  CellTriangles result;
  std::array<int, kCellEdges> next = outline(inside);
  for (int start = 0; start < kCellEdges; ++start) {
    if (next[static_cast<std::size_t>(start)] < 0) continue;
    int previous = next[static_cast<std::size_t>(start)];
    next[static_cast<std::size_t>(start)] = -1;
    while (next[static_cast<std::size_t>(previous)] != start) {
      const int current = next[static_cast<std::size_t>(previous)];
      const auto at = static_cast<std::size_t>(3 * result.count++);
      result.edges[at] = static_cast<std::int8_t>(start);
      result.edges[at + 1] = static_cast<std::int8_t>(previous);
      result.edges[at + 2] = static_cast<std::int8_t>(current);
      next[static_cast<std::size_t>(previous)] = -1;
      previous = current;
    }
    next[static_cast<std::size_t>(previous)] = -1;
  }
  return result;
}

constexpr std::array<CellTriangles, 256> all_cells() {
  std::array<CellTriangles, 256> table{};
  for (int inside = 0; inside < 256; ++inside) table[static_cast<std::size_t>(inside)] = triangulate(inside);
  return table;
}

}  // namespace detail

inline constexpr std::array<CellTriangles, 256> kCellTable = detail::all_cells();

}  // namespace plumbline::kernels
