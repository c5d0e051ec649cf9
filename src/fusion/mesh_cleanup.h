// What a fused mesh is rid of before it is written.
#pragma once

#include <cstddef>

#include "plumbline/mesh.h"

namespace plumbline {

/// m² of surface.
double area_of(const Mesh& mesh);

/// Removes connected pieces of surface with less area (m²); returns how many.
std::size_t remove_islands(double min_area, Mesh* mesh);

/// Collapses edges down to so many triangles, or as near to that as the surface's topology allows (Garland and Heckbert
/// 1997, by meshoptimizer). Vertices that stay keep their normal and colour.
void simplify(std::size_t max_triangles, Mesh* mesh);

}  // namespace plumbline
