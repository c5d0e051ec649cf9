// Triangle meshes as PLY, OBJ, STL and GLB files: plumbline/files.h, and the formats by name.
#pragma once

#include <string>

#include "plumbline/files.h"
#include "plumbline/mesh.h"

namespace plumbline {

/// Throws Error unless the name ends as that of a mesh that can be written.
void check_mesh_format(const std::string& path);

/// Binary little-endian PLY: float positions (m) and normals, uchar colours, faces as `list uchar int vertex_indices`.
void write_ply(const std::string& path, const Mesh& mesh);

/// Wavefront OBJ; colours follow the position on its `v` line, 0 to 1, as most programs read them.
void write_obj(const std::string& path, const Mesh& mesh);

/// Binary STL: triangles with their own normals, without colours; metres.
void write_stl(const std::string& path, const Mesh& mesh);

/// Binary glTF 2.0, positions in metres. A node turns the first camera's axes (y down) to glTF's (y up), so that what
/// the camera saw upright stands upright. Colours become linear. Throws Error also for a mesh without triangles.
void write_glb(const std::string& path, const Mesh& mesh);

/// PLY 1.0: ascii, binary_little_endian, binary_big_endian.
Mesh read_ply(const std::string& path);

/// Positions, `v x y z r g b` colours, normals and faces; the rest is skipped. A vertex whose corners have different
/// normals gets their mean direction.
Mesh read_obj(const std::string& path);

/// Throws Error if the parts of the mesh do not fit together; `path` is where it was to be written.
void check_mesh(const Mesh& mesh, const std::string& path);

}  // namespace plumbline
