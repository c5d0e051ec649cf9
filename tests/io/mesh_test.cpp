#include "io/mesh.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include "io/mesh_samples.h"
#include "plumbline/mesh.h"
#include "support/error_of.h"
#include "support/temp_folder.h"

namespace plumbline {
namespace {

using test::error_of;
using test::make_strip;
using test::read_text;
using test::TempFolder;
using test::write_text;
using testing::HasSubstr;

Mesh read_from_text(const char* name, std::string_view text) {
  const TempFolder folder;
  write_text(folder / name, text);
  return read_mesh(folder / name);
}

std::string error_from_text(const char* name, std::string_view text) {
  return error_of([&] { read_from_text(name, text); });
}

template <class T>
std::string bytes_of(T value, bool big) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  if (big) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

std::string ply_header(const std::string& format, const std::string& vertices, const std::string& faces) {
  return "ply\nformat " + format + " 1.0\nelement vertex " + vertices +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

/// Three vertices and a triangle of the given indices.
std::string small_ply(const std::string& vertices, const std::string& faces, std::initializer_list<int> indices) {
  std::string text = ply_header("binary_little_endian", vertices, faces);
  for (int i = 0; i < 9; ++i) text += bytes_of(static_cast<float>(i), false);
  text += static_cast<char>(indices.size());
  for (const int i : indices) text += bytes_of(i, false);
  return text;
}

TEST(Mesh, WrittenFilesReadBack) {
  const TempFolder folder;
  for (const char* name : {"m.ply", "m.obj", "M.PLY"})
    for (const bool normals : {false, true})
      for (const bool colors : {false, true}) {
        const Mesh mesh = make_strip(50, normals, colors);
        write_mesh(folder / name, mesh);
        test::expect_equal(read_mesh(folder / name), mesh);
      }
}

TEST(Mesh, MoreVerticesThanABlockReadBack) {
  const TempFolder folder;
  const Mesh mesh = make_strip(20000, true, true);
  write_ply(folder / "m.ply", mesh);
  const Mesh read = read_ply(folder / "m.ply");
  ASSERT_EQ(read.positions.size(), mesh.positions.size());
  ASSERT_EQ(read.triangles.size(), mesh.triangles.size());
  EXPECT_EQ(std::memcmp(read.positions.data(), mesh.positions.data(), mesh.positions.size() * 12), 0);
  EXPECT_EQ(std::memcmp(read.normals.data(), mesh.normals.data(), mesh.normals.size() * 12), 0);
  EXPECT_EQ(std::memcmp(read.triangles.data(), mesh.triangles.data(), mesh.triangles.size() * 12), 0);
}

TEST(Mesh, PointCloudAndEmptyMesh) {
  const TempFolder folder;
  Mesh cloud = make_strip(10, true, true);
  cloud.triangles.clear();
  for (const char* name : {"m.ply", "m.obj"}) {
    write_mesh(folder / name, cloud);
    test::expect_equal(read_mesh(folder / name), cloud);
  }
  write_ply(folder / "empty.ply", Mesh());
  EXPECT_TRUE(read_ply(folder / "empty.ply").positions.empty());
}

TEST(Mesh, ObjKeepsNormalsOfVerticesWithoutAFace) {
  const TempFolder folder;
  Mesh mesh = make_strip(10, true, true);
  mesh.triangles.resize(2);
  write_obj(folder / "m.obj", mesh);
  test::expect_equal(read_obj(folder / "m.obj"), mesh);
}

TEST(Mesh, RefusesToWriteWhatDoesNotFitTogether) {
  const TempFolder folder;
  write_ply(folder / "m.ply", make_strip(3, false, false));
  const std::string old = read_text(folder / "m.ply");
  Mesh mesh = make_strip(5, true, true);
  mesh.normals.pop_back();
  EXPECT_THAT(error_of([&] { write_mesh(folder / "m.ply", mesh); }), HasSubstr("normals"));
  mesh = make_strip(5, true, true);
  mesh.colors.pop_back();
  EXPECT_THAT(error_of([&] { write_mesh(folder / "m.obj", mesh); }), HasSubstr("colours"));
  mesh = make_strip(5, true, true);
  mesh.triangles.push_back({0, 1, 10});
  EXPECT_THAT(error_of([&] { write_mesh(folder / "m.ply", mesh); }), HasSubstr("a vertex that the mesh does not have"));
  EXPECT_THAT(error_of([&] { write_mesh(folder / "m.xyz", mesh); }), HasSubstr(".ply, .obj, .stl or .glb"));
  EXPECT_THAT(error_of([&] { write_mesh(folder / "m.glb", Mesh()); }), HasSubstr("no triangles"));
  EXPECT_THAT(error_of([&] { read_mesh(folder / "m"); }), HasSubstr(".ply or .obj"));
  EXPECT_EQ(read_text(folder / "m.ply"), old);
}

TEST(Ply, ReadsAsciiPolygonsAsFansAndSkipsTheRest) {
  const Mesh mesh =
      read_from_text("m.ply",
                     "ply\r\nformat ascii 1.0\r\ncomment a comment\r\nobj_info x\r\n"
                     "element camera 2\r\nproperty double focal\r\nproperty list uchar float rest\r\n"
                     "element vertex 5\r\nproperty double x\r\nproperty float confidence\r\n"
                     "property double y\r\nproperty double z\r\nproperty list uchar int seen\r\n"
                     "property uint8 red\r\nproperty uint8 green\r\nproperty uint8 blue\r\n"
                     "element face 3\r\nproperty uchar flags\r\n"
                     "property list uint8 int32 vertex_index\r\nend_header\r\n"
                     "1.5 2 7 8\n2.5 0\n"
                     "0 9 0 0 0 1 2 3\n1 9 0 0 2 5 6 4 5 6\n1 9 1 0 0 7 8 9\n0 9 1 0 0 1 1 1\n-1e0 9 5e-1 0 0 2 2 2\n"
                     "1 5 0 1 2 3 4\n1 3 2 1 0\n1 2 0 1");
  ASSERT_EQ(mesh.positions.size(), 5u);
  test::expect_equal(mesh.positions[4], Mesh::Float3{-1, 0.5f, 0});
  EXPECT_EQ(mesh.colors[1].g, 5);
  EXPECT_TRUE(mesh.normals.empty());
  ASSERT_EQ(mesh.triangles.size(), 4u);  // three of the pentagon, one triangle, none of the line
  EXPECT_EQ(mesh.triangles[2].a, 0u);
  EXPECT_EQ(mesh.triangles[2].b, 3u);
  EXPECT_EQ(mesh.triangles[2].c, 4u);
  EXPECT_EQ(mesh.triangles[3].a, 2u);
}

TEST(Ply, ReadsBothByteOrdersAndEveryType) {
  for (const bool big : {false, true}) {
    std::string text = std::string("ply\nformat ") + (big ? "binary_big_endian" : "binary_little_endian") +
                       " 1.0\nelement vertex 3\nproperty short x\nproperty double y\nproperty uint z\n"
                       "property float red\nproperty ushort green\nproperty char blue\n"
                       "element face 1\nproperty list ushort uint vertex_indices\nend_header\n";
    for (int i = 0; i < 3; ++i) {
      text += bytes_of(static_cast<std::int16_t>(-300 * i), big) + bytes_of(0.25 * i, big);
      text += bytes_of(static_cast<std::uint32_t>(3000000000u), big) + bytes_of(0.5f, big);
      text += bytes_of(static_cast<std::uint16_t>(65535), big) + bytes_of(static_cast<std::int8_t>(-5), big);
    }
    text += bytes_of(static_cast<std::uint16_t>(3), big);
    for (const std::uint32_t i : {2u, 0u, 1u}) text += bytes_of(i, big);
    const Mesh mesh = read_from_text("m.ply", text);
    test::expect_equal(mesh.positions[2], Mesh::Float3{-600, 0.5f, 3e9f});
    EXPECT_EQ(mesh.colors[0].r, 128);
    EXPECT_EQ(mesh.colors[0].g, 255);
    EXPECT_EQ(mesh.colors[0].b, 0);
    ASSERT_EQ(mesh.triangles.size(), 1u);
    EXPECT_EQ(mesh.triangles[0].a, 2u);
    EXPECT_EQ(mesh.triangles[0].c, 1u);
  }
}

TEST(Ply, EveryTruncationIsAnError) {
  const TempFolder folder;
  write_ply(folder / "m.ply", make_strip(6, true, true));
  const std::string whole = read_text(folder / "m.ply");
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_THROW(read_from_text("cut.ply", std::string_view(whole).substr(0, size)), Error) << size;
  const std::string ascii = ply_header("ascii", "3", "1") + "0 0 0 1 1 1 2 2 2 3 0 1 2";
  EXPECT_EQ(read_from_text("m.ply", ascii).triangles.size(), 1u);
  for (std::size_t size = 0; size < ascii.size(); ++size)
    EXPECT_THROW(read_from_text("cut.ply", std::string_view(ascii).substr(0, size)), Error) << size;
}

TEST(Ply, HostileCountsAreRefused) {
  EXPECT_EQ(read_from_text("m.ply", small_ply("3", "1", {0, 1, 2})).triangles.size(), 1u);
  for (const char* count : {"4000000000", "9223372036854775807", "5"}) {
    EXPECT_THAT(error_from_text("m.ply", small_ply(count, "1", {0, 1, 2})), HasSubstr("too short")) << count;
  }
  EXPECT_THAT(error_from_text("m.ply", small_ply("3", "4000000000", {0, 1, 2})), HasSubstr("too short"));
  EXPECT_THAT(error_from_text("m.ply", small_ply("-3", "1", {0, 1, 2})), HasSubstr("not a number"));
  EXPECT_THAT(error_from_text("m.ply", small_ply("99999999999999999999", "1", {})), HasSubstr("not a number"));
  EXPECT_THAT(error_from_text("m.ply", small_ply("3", "1", {0, 1, 3})), HasSubstr("vertex 3 of 3"));
  EXPECT_THAT(error_from_text("m.ply", small_ply("3", "1", {0, -1, 2})), HasSubstr("vertex -1"));
  const std::string list =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nproperty list uint uint l\nend_header\n0 0 0 ";
  EXPECT_THAT(error_from_text("m.ply", list + "4294967295 1"), HasSubstr("too short"));
  EXPECT_THAT(error_from_text("m.ply", list + "-1 1"), HasSubstr("impossible length"));
  EXPECT_THAT(error_from_text("m.ply", list + "nan 1"), HasSubstr("impossible length"));
}

TEST(Ply, MalformedHeadersAreErrorsWithTheirLine) {
  EXPECT_THAT(error_from_text("m.ply", "plx\n"), testing::AllOf(HasSubstr("m.ply:1"), HasSubstr("'ply'")));
  EXPECT_THAT(error_from_text("m.ply", "ply\nformat binary 1.0\n"), HasSubstr("m.ply:2"));
  EXPECT_THAT(error_from_text("m.ply", "ply\nend_header\n"), HasSubstr("no 'format'"));
  const std::string start = "ply\nformat ascii 1.0\n";
  EXPECT_THAT(error_from_text("m.ply", start + "property float x\n"), HasSubstr("before the first element"));
  EXPECT_THAT(error_from_text("m.ply", start + "element vertex 1\nproperty real x\n"), HasSubstr("m.ply:4"));
  EXPECT_THAT(error_from_text("m.ply", start + "element vertex 1\nproperty list uchar x\n"), HasSubstr("malformed"));
  EXPECT_THAT(error_from_text("m.ply", start + "nonsense here\n"), HasSubstr("not part of"));
  EXPECT_THAT(error_from_text("m.ply", start + "element face 0\nend_header\n"), HasSubstr("no 'vertex'"));
  EXPECT_THAT(error_from_text("m.ply", start + "element vertex 1\nproperty float x\nend_header\n1\n"),
              HasSubstr("lack x"));
  EXPECT_THAT(error_from_text("m.ply", ply_header("ascii", "1", "0") + "0 zero 0\n"), HasSubstr("'zero'"));
}

TEST(Obj, ReadsPolygonsNegativeIndicesAndTexturedCorners) {
  const Mesh mesh = read_from_text("m.obj",
                                   "# comment\nmtllib x.mtl\no thing\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0 1.0\n"
                                   "vt 0 0\nvn 0 0 2\nvn 2 0 0\ns off\n"
                                   "f 1/1/1 2/1/1 3/1/1 4/1/1\r\nf -4//2 -3//1 -2//1\n");
  ASSERT_EQ(mesh.positions.size(), 4u);
  ASSERT_EQ(mesh.triangles.size(), 3u);
  EXPECT_EQ(mesh.triangles[1].b, 2u);
  EXPECT_EQ(mesh.triangles[1].c, 3u);
  EXPECT_EQ(mesh.triangles[2].a, 0u);
  EXPECT_EQ(mesh.triangles[2].c, 2u);
  EXPECT_TRUE(mesh.colors.empty());
  ASSERT_EQ(mesh.normals.size(), 4u);
  test::expect_equal(mesh.normals[1], Mesh::Float3{0, 0, 1});
  EXPECT_NEAR(mesh.normals[0].x, std::sqrt(0.5), 1e-6);  // the mean of its two corners
  EXPECT_NEAR(mesh.normals[0].z, std::sqrt(0.5), 1e-6);
}

TEST(Obj, MalformedLinesAreErrorsWithTheirNumber) {
  const std::string start = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
  for (const char* face : {"f 1 2 4", "f 1 2 0", "f 1 2 -4", "f 1 2 x", "f 1 2 3/1/1", "f 1 2 99999999999999999999"})
    EXPECT_THAT(error_from_text("m.obj", start + face + "\n"),
                testing::AllOf(HasSubstr("m.obj:4"), HasSubstr("names none")));
  EXPECT_THAT(error_from_text("m.obj", start + "f 1 2\n"), HasSubstr("fewer than three"));
  EXPECT_THAT(error_from_text("m.obj", "v 0 zero 0\n"), HasSubstr("m.obj:1"));
  EXPECT_THAT(error_from_text("m.obj", "v 0 0\n"), HasSubstr("three numbers"));
  EXPECT_THAT(error_from_text("m.obj", "# nothing\n"), HasSubstr("no vertices"));
}

}  // namespace
}  // namespace plumbline
