// PLY as described by Greg Turk, "The PLY Polygon File Format", 1994.
//
// The reader is our own: assimp 5.2 takes a binary file that ends early for a whole one and hands out indices beyond
// the vertices, and no other library of the distribution reads PLY alone. The tests read our files with assimp.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "io/atomic_file.h"
#include "io/mesh.h"
#include "io/text_file.h"
#include "plumbline/error.h"
#include "plumbline/mesh.h"

namespace plumbline {
namespace {

static_assert(std::endian::native == std::endian::little, "the writer copies values as they lie in memory");

constexpr const char* kDamagedAdvice = "write or download the mesh again";

// ---- Writing
// ---------------------------------------------------------------------------------------------------------

std::string header_of(const Mesh& mesh) {
  std::string header = "ply\nformat binary_little_endian 1.0\ncomment units metres\n";
  header +=
      fmt::format("element vertex {}\nproperty float x\nproperty float y\nproperty float z\n", mesh.positions.size());
  if (!mesh.normals.empty()) header += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!mesh.colors.empty()) header += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  header += fmt::format("element face {}\nproperty list uchar int vertex_indices\nend_header\n", mesh.triangles.size());
  return header;
}

template <class T>
char* put(char* out, const T& value) {
  std::memcpy(out, &value, sizeof(T));
  return out + sizeof(T);
}

/// Calls `put_one(i, out)` for i < count, which returns the end of what it put, at most `bytes_each` further on.
template <class PutOne>
void write_blocks(AtomicFile* file, std::size_t count, std::size_t bytes_each, PutOne&& put_one) {
  constexpr std::size_t kBlock = 16384;
  std::vector<char> block(std::min(count, kBlock) * bytes_each);
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    char* out = block.data();
    for (std::size_t i = begin; i < std::min(count, begin + kBlock); ++i) out = put_one(i, out);
    file->write(block.data(), static_cast<std::size_t>(out - block.data()));
  }
}

// ---- Reading: header
// -------------------------------------------------------------------------------------------------

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

std::optional<Type> type_by_name(std::string_view name) {
  struct Name {
    std::string_view name;
    Type type;
  };
  constexpr std::array<Name, 16> kNames = {{{"char", Type::int8},
                                            {"int8", Type::int8},
                                            {"uchar", Type::uint8},
                                            {"uint8", Type::uint8},
                                            {"short", Type::int16},
                                            {"int16", Type::int16},
                                            {"ushort", Type::uint16},
                                            {"uint16", Type::uint16},
                                            {"int", Type::int32},
                                            {"int32", Type::int32},
                                            {"uint", Type::uint32},
                                            {"uint32", Type::uint32},
                                            {"float", Type::float32},
                                            {"float32", Type::float32},
                                            {"double", Type::float64},
                                            {"float64", Type::float64}}};
  for (const Name& n : kNames)
    if (n.name == name) return n.type;
  return std::nullopt;
}

std::size_t size_of(Type type) {
  constexpr std::array<std::size_t, 8> kSizes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

struct Property {
  std::string name;
  Type type = Type::float32;
  bool is_list = false;
  Type count_type = Type::uint8;
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;

  int find(std::initializer_list<std::string_view> names) const {
    for (const std::string_view wanted : names)
      for (std::size_t i = 0; i < properties.size(); ++i)
        if (properties[i].name == wanted) return static_cast<int>(i);
    return -1;
  }
};

enum class Encoding { ascii, little, big };

struct PlyHeader {
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
  std::size_t end = 0;  // offset of the first byte after it
};

/// Reads the header's lines and says which one is wrong.
class HeaderParser {
 public:
  HeaderParser(std::string_view bytes, const std::string& path) : bytes_(bytes), path_(path) {}

  PlyHeader parse() {
    if (next_line() != "ply") fail("does not begin with 'ply'");
    for (;;) {
      const std::vector<std::string_view> words = split_fields(next_line());
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      parse_line(words);
    }
    if (!has_format_) fail("has no 'format' line");
    header_.end = offset_;
    return std::move(header_);
  }

 private:
  std::string_view next_line() {
    const std::size_t end = bytes_.find('\n', offset_);
    if (end == std::string_view::npos) fail("the header does not end");
    const std::string_view line = trim(bytes_.substr(offset_, end - offset_));
    offset_ = end + 1;
    ++line_;
    return line;
  }

  void parse_line(const std::vector<std::string_view>& words) {
    if (words[0] == "format" && words.size() == 3) return parse_format(words[1]);
    if (words[0] == "element" && words.size() == 3) return parse_element(words);
    if (words[0] == "property" && words.size() >= 3) return parse_property(words);
    fail("the line is not part of a PLY header");
  }

  void parse_format(std::string_view name) {
    has_format_ = true;
    if (name == "ascii")
      header_.encoding = Encoding::ascii;
    else if (name == "binary_little_endian")
      header_.encoding = Encoding::little;
    else if (name == "binary_big_endian")
      header_.encoding = Encoding::big;
    else
      fail("the format is unknown");
  }

  void parse_element(const std::vector<std::string_view>& words) {
    const auto count = parse_unsigned(words[2]);
    if (!count) fail("the element's count is not a number");
    header_.elements.push_back({std::string(words[1]), static_cast<std::size_t>(*count), {}});
  }

  void parse_property(const std::vector<std::string_view>& words) {
    if (header_.elements.empty()) fail("a property stands before the first element");
    Property property;
    property.is_list = words[1] == "list";
    if (words.size() != (property.is_list ? 5u : 3u)) fail("the property is malformed");
    const auto type = type_by_name(words[property.is_list ? 3 : 1]);
    const auto count_type = property.is_list ? type_by_name(words[2]) : Type::uint8;
    if (!type || !count_type) fail("the property's type is unknown");
    property.type = *type;
    property.count_type = *count_type;
    property.name = words.back();
    header_.elements.back().properties.push_back(std::move(property));
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(what, path_ + ":" + std::to_string(line_), "give a PLY file, version 1.0");
  }

  std::string_view bytes_;
  std::string path_;
  std::size_t offset_ = 0;
  int line_ = 0;
  bool has_format_ = false;
  PlyHeader header_;
};

// ---- Reading: values
// -------------------------------------------------------------------------------------------------

template <class T>
double value_at(const char* data, bool swap) {
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), data, sizeof(T));
  if (swap) std::reverse(bytes.begin(), bytes.end());
  return static_cast<double>(std::bit_cast<T>(bytes));
}

double value_at(const char* data, Type type, bool swap) {
  switch (type) {
    case Type::int8:
      return value_at<std::int8_t>(data, swap);
    case Type::uint8:
      return value_at<std::uint8_t>(data, swap);
    case Type::int16:
      return value_at<std::int16_t>(data, swap);
    case Type::uint16:
      return value_at<std::uint16_t>(data, swap);
    case Type::int32:
      return value_at<std::int32_t>(data, swap);
    case Type::uint32:
      return value_at<std::uint32_t>(data, swap);
    case Type::float32:
      return value_at<float>(data, swap);
    default:
      return value_at<double>(data, swap);
  }
}

/// The values after the header, one after the other. Every value of every type fits a double.
class Values {
 public:
  Values(std::string_view bytes, Encoding encoding, const std::string& path)
      : rest_(bytes), encoding_(encoding), path_(path) {}

  double next(Type type) { return encoding_ == Encoding::ascii ? next_word() : next_binary(type); }

  /// How many bytes a value takes at the least: in text a digit and a blank.
  std::size_t least_bytes(Type type) const { return encoding_ == Encoding::ascii ? 2 : size_of(type); }

  /// Throws unless `count` times `bytes` can still follow, so that no count of a damaged file is trusted.
  void require(std::size_t count, std::size_t bytes, const std::string& of) const {
    // The very last number of a text needs no blank after it.
    const std::size_t left = rest_.size() + (encoding_ == Encoding::ascii ? 1 : 0);
    if (bytes > 0 && count > left / bytes)
      throw Error("the file is too short for its " + std::to_string(count) + " " + of, path_, kDamagedAdvice);
  }

 private:
  double next_binary(Type type) {
    const std::size_t size = size_of(type);
    if (rest_.size() < size) throw Error("the file ends early", path_, kDamagedAdvice);
    const double value = value_at(rest_.data(), type, encoding_ == Encoding::big);
    rest_.remove_prefix(size);
    return value;
  }

  double next_word() {
    constexpr std::string_view kBlank = " \t\r\n";
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kBlank), rest_.size()));
    if (rest_.empty()) throw Error("the file ends early", path_, kDamagedAdvice);
    const std::string_view word = rest_.substr(0, rest_.find_first_of(kBlank));
    rest_.remove_prefix(word.size());
    const auto value = parse_double(word);
    if (!value) throw Error(fmt::format("'{}' is not a number", word.substr(0, 40)), path_, kDamagedAdvice);
    return *value;
  }

  std::string_view rest_;
  Encoding encoding_;
  std::string path_;
};

// ---- Reading: elements
// -----------------------------------------------------------------------------------------------

/// A colour channel of any type as 8 bits: real numbers run from 0 to 1, wider integers over their range.
std::uint8_t to_channel(double value, Type type) {
  if (type == Type::float32 || type == Type::float64) value *= 255;
  if (type == Type::uint16) value /= 257;
  return static_cast<std::uint8_t>(std::lround(std::clamp(std::isfinite(value) ? value : 0.0, 0.0, 255.0)));
}

class PlyReader {
 public:
  PlyReader(const std::string& path, std::string_view bytes)
      : path_(path),
        header_(HeaderParser(bytes, path).parse()),
        values_(bytes.substr(header_.end), header_.encoding, path) {}

  Mesh read() {
    bool has_vertices = false;
    for (const Element& element : header_.elements) {
      require_bytes(element);
      if (element.name == "vertex" && !has_vertices) {
        read_vertices(element);
        has_vertices = true;
      } else if (element.name == "face" && element.find({"vertex_indices", "vertex_index"}) >= 0) {
        read_faces(element);
      } else {
        skip(element);
      }
    }
    if (!has_vertices) throw Error("has no 'vertex' element", path_, "give a mesh or a point cloud");
    check_indices();
    return std::move(mesh_);
  }

 private:
  void require_bytes(const Element& element) const {
    std::size_t bytes = 0;
    for (const Property& p : element.properties) bytes += values_.least_bytes(p.is_list ? p.count_type : p.type);
    values_.require(element.count, bytes, "elements '" + element.name + "'");
  }

  void read_vertices(const Element& element) {
    const std::array<int, 3> xyz = {element.find({"x"}), element.find({"y"}), element.find({"z"})};
    const std::array<int, 3> normal = {element.find({"nx"}), element.find({"ny"}), element.find({"nz"})};
    const std::array<int, 3> color = {element.find({"red", "diffuse_red", "r"}),
                                      element.find({"green", "diffuse_green", "g"}),
                                      element.find({"blue", "diffuse_blue", "b"})};
    const auto all = [](const std::array<int, 3>& a) { return a[0] >= 0 && a[1] >= 0 && a[2] >= 0; };
    if (!all(xyz)) throw Error("the vertices lack x, y or z", path_, "give a mesh with positions");
    mesh_.positions.resize(element.count);
    if (all(normal)) mesh_.normals.resize(element.count);
    if (all(color)) mesh_.colors.resize(element.count);
    std::vector<double> row(element.properties.size());
    const auto float3 = [&row](const std::array<int, 3>& at) {
      return Mesh::Float3{static_cast<float>(row[at[0]]), static_cast<float>(row[at[1]]),
                          static_cast<float>(row[at[2]])};
    };
    const auto channel = [&](int at) { return to_channel(row[at], element.properties[at].type); };
    for (std::size_t i = 0; i < element.count; ++i) {
      read_row(element, &row);
      mesh_.positions[i] = float3(xyz);
      if (!mesh_.normals.empty()) mesh_.normals[i] = float3(normal);
      if (!mesh_.colors.empty()) mesh_.colors[i] = {channel(color[0]), channel(color[1]), channel(color[2])};
    }
  }

  /// The scalars of one element; a list's place holds 0.
  void read_row(const Element& element, std::vector<double>* row) {
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const Property& p = element.properties[i];
      (*row)[i] = p.is_list ? 0 : values_.next(p.type);
      if (p.is_list) skip_list(p);
    }
  }

  std::size_t read_count(const Property& list) {
    const double count = values_.next(list.count_type);
    if (!(count >= 0 && count == std::floor(count) && count <= std::numeric_limits<std::uint32_t>::max()))
      throw Error("a list has an impossible length", path_, kDamagedAdvice);
    values_.require(static_cast<std::size_t>(count), values_.least_bytes(list.type), "list values");
    return static_cast<std::size_t>(count);
  }

  void skip_list(const Property& list) {
    for (std::size_t n = read_count(list); n > 0; --n) values_.next(list.type);
  }

  void read_faces(const Element& element) {
    const int indices = element.find({"vertex_indices", "vertex_index"});
    mesh_.triangles.reserve(mesh_.triangles.size() + element.count);
    for (std::size_t i = 0; i < element.count; ++i) {
      for (int p = 0; p < static_cast<int>(element.properties.size()); ++p) {
        const Property& property = element.properties[p];
        if (p == indices && property.is_list)
          read_polygon(property);
        else if (property.is_list)
          skip_list(property);
        else
          values_.next(property.type);
      }
    }
  }

  void read_polygon(const Property& list) {
    std::uint32_t first = 0, previous = 0;
    const std::size_t corners = read_count(list);
    for (std::size_t i = 0; i < corners; ++i) {
      const double value = values_.next(list.type);
      // Vertices may follow the faces, so only now is it certain that an index is one at all.
      if (!(value >= 0 && value == std::floor(value) && value < std::numeric_limits<std::uint32_t>::max()))
        throw Error(fmt::format("a face names vertex {}", value), path_, kDamagedAdvice);
      const auto index = static_cast<std::uint32_t>(value);
      if (i == 0) first = index;
      if (i >= 2) mesh_.triangles.push_back({first, previous, index});
      previous = index;
    }
  }

  void skip(const Element& element) {
    if (element.properties.empty()) return;
    std::vector<double> row(element.properties.size());
    for (std::size_t i = 0; i < element.count; ++i) read_row(element, &row);
  }

  void check_indices() const {
    const std::size_t n = mesh_.positions.size();
    for (const Mesh::Triangle& t : mesh_.triangles)
      if (std::max({t.a, t.b, t.c}) >= n)
        throw Error(fmt::format("a face names vertex {} of {}", std::max({t.a, t.b, t.c}), n), path_, kDamagedAdvice);
  }

  std::string path_;
  PlyHeader header_;
  Values values_;
  Mesh mesh_;
};

}  // namespace

void write_ply(const std::string& path, const Mesh& mesh) {
  check_mesh(mesh, path);
  AtomicFile file(path);
  file.write(header_of(mesh));
  const bool normals = !mesh.normals.empty(), colors = !mesh.colors.empty();
  write_blocks(&file, mesh.positions.size(), 27, [&](std::size_t i, char* out) {
    out = put(out, mesh.positions[i]);
    if (normals) out = put(out, mesh.normals[i]);
    if (colors) out = put(out, mesh.colors[i]);
    return out;
  });
  write_blocks(&file, mesh.triangles.size(), 13,
               [&](std::size_t i, char* out) { return put(put(out, std::uint8_t{3}), mesh.triangles[i]); });
  file.commit();
}

Mesh read_ply(const std::string& path) {
  const std::string bytes = read_file(path);
  return PlyReader(path, bytes).read();
}

}  // namespace plumbline
