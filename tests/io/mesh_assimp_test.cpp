// Our mesh files as another program reads them.
#include <assimp/scene.h>

#include <assimp/Importer.hpp>

#include "io/mesh.h"
#include "io/mesh_samples.h"
#include "plumbline/mesh.h"
#include "support/temp_folder.h"

namespace plumbline {
namespace {

Mesh read_with_assimp(const std::string& path) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path, 0);
  Mesh mesh;
  if (scene == nullptr || scene->mNumMeshes != 1) {
    ADD_FAILURE() << path << ": " << importer.GetErrorString();
    return mesh;
  }
  const aiMesh& m = *scene->mMeshes[0];
  const auto channel = [](float c) { return static_cast<std::uint8_t>(std::lround(c * 255)); };
  for (unsigned i = 0; i < m.mNumVertices; ++i) {
    mesh.positions.push_back({m.mVertices[i].x, m.mVertices[i].y, m.mVertices[i].z});
    if (m.HasNormals()) mesh.normals.push_back({m.mNormals[i].x, m.mNormals[i].y, m.mNormals[i].z});
    if (m.HasVertexColors(0)) {
      const aiColor4D& c = m.mColors[0][i];
      mesh.colors.push_back({channel(c.r), channel(c.g), channel(c.b)});
    }
  }
  for (unsigned i = 0; i < m.mNumFaces; ++i) {
    if (m.mFaces[i].mNumIndices != 3) {
      ADD_FAILURE() << "a face of " << m.mFaces[i].mNumIndices;
      continue;
    }
    const unsigned* v = m.mFaces[i].mIndices;
    mesh.triangles.push_back({v[0], v[1], v[2]});
  }
  return mesh;
}

/// One vertex a corner, as assimp hands out OBJ files.
Mesh unshared(const Mesh& mesh) {
  Mesh result;
  for (const Mesh::Triangle& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(result.positions.size());
    for (const std::uint32_t i : {t.a, t.b, t.c}) {
      result.positions.push_back(mesh.positions[i]);
      if (!mesh.normals.empty()) result.normals.push_back(mesh.normals[i]);
      if (!mesh.colors.empty()) result.colors.push_back(mesh.colors[i]);
    }
    result.triangles.push_back({first, first + 1, first + 2});
  }
  return result;
}

TEST(MeshAssimp, ReadsOurPly) {
  const test::TempFolder folder;
  for (const bool normals : {false, true})
    for (const bool colors : {false, true}) {
      const Mesh mesh = test::make_strip(40, normals, colors);
      write_mesh(folder / "m.ply", mesh);
      test::expect_equal(read_with_assimp(folder / "m.ply"), mesh);
    }
}

TEST(MeshAssimp, ReadsOurObj) {
  const test::TempFolder folder;
  for (const bool normals : {false, true})
    for (const bool colors : {false, true}) {
      const Mesh mesh = test::make_strip(40, normals, colors);
      write_mesh(folder / "m.obj", mesh);
      test::expect_equal(unshared(read_with_assimp(folder / "m.obj")), unshared(mesh));
    }
}

/// glTF's colours are linear; assimp hands them out as they are.
Mesh with_linear_colors(Mesh mesh) {
  const auto linear = [](std::uint8_t c) {
    const double x = c / 255.0;
    return static_cast<std::uint8_t>(
        std::lround(255 * (x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4))));
  };
  for (Mesh::Rgb& c : mesh.colors) c = {linear(c.r), linear(c.g), linear(c.b)};
  return mesh;
}

TEST(MeshAssimp, ReadsOurGlb) {
  const test::TempFolder folder;
  for (const bool normals : {false, true})
    for (const bool colors : {false, true}) {
      const Mesh mesh = test::make_strip(40, normals, colors);
      write_mesh(folder / "m.glb", mesh);
      test::expect_equal(read_with_assimp(folder / "m.glb"), with_linear_colors(mesh));
    }
}

TEST(MeshAssimp, GlbStandsUpright) {
  const test::TempFolder folder;
  write_mesh(folder / "m.glb", test::make_strip(5, true, true));
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(folder / "m.glb", 0);
  ASSERT_NE(scene, nullptr);
  const aiNode& root = *scene->mRootNode;
  const aiMatrix4x4 turn =
      root.mNumMeshes > 0 ? root.mTransformation : root.mTransformation * root.mChildren[0]->mTransformation;
  const aiVector3D down = turn * aiVector3D(0, 1, 0), ahead = turn * aiVector3D(0, 0, 1);
  EXPECT_NEAR(down.y, -1, 1e-6);
  EXPECT_NEAR(ahead.z, -1, 1e-6);
}

TEST(MeshAssimp, ReadsOurStl) {
  const test::TempFolder folder;
  const Mesh mesh = test::make_strip(40, false, false);
  write_mesh(folder / "m.stl", mesh);
  Mesh read = read_with_assimp(folder / "m.stl");
  EXPECT_FALSE(read.normals.empty());
  read.normals.clear();
  test::expect_equal(unshared(read), unshared(mesh));
}

}  // namespace
}  // namespace plumbline
