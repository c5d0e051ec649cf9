// Wavefront OBJ: the part of it that triangle meshes use.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "io/atomic_file.h"
#include "io/mesh.h"
#include "io/text_file.h"
#include "plumbline/error.h"
#include "plumbline/mesh.h"

namespace plumbline {
namespace {

// ---- Writing
// ---------------------------------------------------------------------------------------------------------

/// Text collected and handed on in blocks.
class Lines {
 public:
  explicit Lines(AtomicFile* file) : file_(file) {}

  template <class... Args>
  void add(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(buffer_), format, std::forward<Args>(args)...);
    if (buffer_.size() > kBlock) flush();
  }

  void flush() {
    file_->write(buffer_.data(), buffer_.size());
    buffer_.clear();
  }

 private:
  static constexpr std::size_t kBlock = 1 << 16;
  AtomicFile* file_;
  fmt::memory_buffer buffer_;
};

void write_vertices(Lines* lines, const Mesh& mesh) {
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Mesh::Float3& p = mesh.positions[i];
    if (mesh.colors.empty()) {
      lines->add("v {} {} {}\n", p.x, p.y, p.z);
    } else {
      // Four decimals are enough to find the 8-bit value again.
      const Mesh::Rgb& c = mesh.colors[i];
      lines->add("v {} {} {} {:.4f} {:.4f} {:.4f}\n", p.x, p.y, p.z, c.r / 255.0, c.g / 255.0, c.b / 255.0);
    }
  }
  for (const Mesh::Float3& n : mesh.normals) lines->add("vn {} {} {}\n", n.x, n.y, n.z);
}

void write_faces(Lines* lines, const Mesh& mesh) {
  for (const Mesh::Triangle& t : mesh.triangles) {
    const std::uint32_t a = t.a + 1, b = t.b + 1, c = t.c + 1;
    if (mesh.normals.empty()) {
      lines->add("f {} {} {}\n", a, b, c);
    } else {
      lines->add("f {0}//{0} {1}//{1} {2}//{2}\n", a, b, c);
    }
  }
}

// ---- Reading
// ---------------------------------------------------------------------------------------------------------

constexpr const char* kObjAdvice = "give a Wavefront OBJ file";

struct Corner {
  std::uint32_t vertex = 0;
  long long normal = -1;  // none
};

class ObjReader {
 public:
  explicit ObjReader(const std::string& path) : file_(path) {}

  Mesh read() {
    for (const TextLine& line : file_.lines()) {
      const std::vector<std::string_view> fields = split_fields(line.text);
      if (fields[0] == "v") read_vertex(line, fields);
      if (fields[0] == "vn") normals_.push_back(read_float3(line, fields));
      if (fields[0] == "f") read_face(line, fields);
    }
    if (mesh_.positions.empty()) throw Error("has no vertices", file_.path(), kObjAdvice);
    if (mesh_.colors.size() != mesh_.positions.size()) mesh_.colors.clear();
    assign_normals();
    return std::move(mesh_);
  }

 private:
  Mesh::Float3 read_float3(const TextLine& line, const std::vector<std::string_view>& fields, std::size_t first = 1) {
    std::array<float, 3> v{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto value = first + i < fields.size() ? parse_double(fields[first + i]) : std::nullopt;
      if (!value) file_.fail(line, "does not have three numbers", kObjAdvice);
      v[i] = static_cast<float>(*value);
    }
    return {v[0], v[1], v[2]};
  }

  void read_vertex(const TextLine& line, const std::vector<std::string_view>& fields) {
    mesh_.positions.push_back(read_float3(line, fields));
    if (fields.size() < 7) return;
    const Mesh::Float3 c = read_float3(line, fields, 4);
    const auto channel = [](float v) {
      return static_cast<std::uint8_t>(std::lround(std::clamp(std::isfinite(v) ? v : 0.0f, 0.0f, 1.0f) * 255));
    };
    mesh_.colors.push_back({channel(c.x), channel(c.y), channel(c.z)});
  }

  /// 1 is the first and −1 the last so far.
  std::size_t resolve(const TextLine& line, std::string_view text, std::size_t count) const {
    const bool from_end = text.starts_with('-');
    const auto number = parse_unsigned(from_end ? text.substr(1) : text);
    if (!number || *number < 1 || static_cast<std::size_t>(*number) > count)
      file_.fail(line, fmt::format("'{}' names none of the {} before it", text, count), kObjAdvice);
    const auto n = static_cast<std::size_t>(*number);
    return from_end ? count - n : n - 1;
  }

  /// `v`, `v/vt`, `v//vn` or `v/vt/vn`.
  Corner read_corner(const TextLine& line, std::string_view text) const {
    const std::size_t slash = text.find('/');
    Corner corner;
    corner.vertex = static_cast<std::uint32_t>(resolve(line, text.substr(0, slash), mesh_.positions.size()));
    if (slash == std::string_view::npos) return corner;
    const std::size_t second = text.find('/', slash + 1);
    if (second != std::string_view::npos && second + 1 < text.size())
      corner.normal = static_cast<long long>(resolve(line, text.substr(second + 1), normals_.size()));
    return corner;
  }

  void read_face(const TextLine& line, const std::vector<std::string_view>& fields) {
    if (fields.size() < 4) file_.fail(line, "a face has fewer than three corners", kObjAdvice);
    Corner first, previous;
    for (std::size_t i = 1; i < fields.size(); ++i) {
      const Corner corner = read_corner(line, fields[i]);
      if (i == 1) first = corner;
      if (i >= 3) mesh_.triangles.push_back({first.vertex, previous.vertex, corner.vertex});
      corners_.push_back(corner);
      previous = corner;
    }
  }

  void assign_normals() {
    const bool one_each = normals_.size() == mesh_.positions.size() &&
                          std::all_of(corners_.begin(), corners_.end(),
                                      [](const Corner& c) { return c.normal == static_cast<long long>(c.vertex); });
    if (normals_.empty()) return;
    if (one_each) {
      mesh_.normals = std::move(normals_);
    } else {
      average_normals();
    }
  }

  void average_normals() {
    std::vector<std::array<double, 3>> sums(mesh_.positions.size());
    for (const Corner& c : corners_) {
      if (c.normal < 0) return;  // a mesh with normals on some corners only has none worth having
      const Mesh::Float3& n = normals_[static_cast<std::size_t>(c.normal)];
      sums[c.vertex][0] += n.x;
      sums[c.vertex][1] += n.y;
      sums[c.vertex][2] += n.z;
    }
    mesh_.normals.reserve(sums.size());
    for (const auto& s : sums) {
      const double length = std::hypot(s[0], s[1], s[2]);
      const double scale = length > 0 ? 1 / length : 0;
      mesh_.normals.push_back(
          {static_cast<float>(s[0] * scale), static_cast<float>(s[1] * scale), static_cast<float>(s[2] * scale)});
    }
  }

  TextFile file_;
  Mesh mesh_;
  std::vector<Mesh::Float3> normals_;
  std::vector<Corner> corners_;
};

}  // namespace

void write_obj(const std::string& path, const Mesh& mesh) {
  check_mesh(mesh, path);
  AtomicFile file(path);
  file.write("# metres\n");
  Lines lines(&file);
  write_vertices(&lines, mesh);
  write_faces(&lines, mesh);
  lines.flush();
  file.commit();
}

Mesh read_obj(const std::string& path) { return ObjReader(path).read(); }

}  // namespace plumbline
