// Triangle meshes as PLY and OBJ files: plumbline/files.h, and the formats by name.
#pragma once

#include <string>

#include "plumbline/files.h"
#include "plumbline/mesh.h"

namespace plumbline {

/// Binary little-endian PLY: float positions (m) and normals, uchar colours, faces as `list uchar int vertex_indices`.
void write_ply(const std::string& path, const Mesh& mesh);

/// Wavefront OBJ; colours follow the position on its `v` line, 0 to 1, as most programs read them.
void write_obj(const std::string& path, const Mesh& mesh);

/// PLY 1.0: ascii, binary_little_endian, binary_big_endian.
Mesh read_ply(const std::string& path);

/// Positions, `v x y z r g b` colours, normals and faces; the rest is skipped. A vertex whose corners have different
/// normals gets their mean direction.
Mesh read_obj(const std::string& path);

/// Throws Error if the parts of the mesh do not fit together; `path` is where it was to be written.
void check_mesh(const Mesh& mesh, const std::string& path);

}  // namespace plumbline
