#include "sim/depth_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "core/embree_scene.h"
#include "core/random.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/image.h"
#include "plumbline/mesh.h"

namespace plumbline::sim {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr const char* kDepthCameraWhere = "depth camera";
constexpr int kPacket = 8;
constexpr double kHalfPi = std::numbers::pi / 2;
constexpr double kSteepest = radians(82);  ///< radians; the noise formulas end here
/// Neighbours are on two surfaces where their depths differ by more than this fraction.
constexpr float kEdge = 0.04f;

/// What a pixel sees: its depth (0 = nothing), how much of the light the surface gives back, and its unit normal
/// towards the camera, camera frame.
struct Sight {
  float z = 0;
  float reflectance = 0;
  Vector3f normal = Vector3f::Zero();
};
using SightImage = Image<Sight>;

/// Names of random streams, of a frame or of the sensor.
enum NoiseStream : std::uint64_t { kAxial, kShiftX, kShiftY, kHoles, kEdges, kInstant, kDistortion };

/// A Gaussian field of unit variance at every pixel, alike over `spacing` pixels: white noise on a lattice,
/// interpolated linearly and scaled back to unit variance. The lattice lies differently in each frame.
class SmoothField {
 public:
  SmoothField(std::uint64_t key, int width, int height, double spacing)
      : columns_(make_axis(width, spacing, uniform_at(key, 0))), rows_(make_axis(height, spacing, uniform_at(key, 1))) {
    lattice_width_ = static_cast<std::size_t>(columns_.back().cell) + 2;
    const std::size_t count = lattice_width_ * (static_cast<std::size_t>(rows_.back().cell) + 2);
    lattice_.resize(count);
    // Both of Box and Muller's deviates are used: the noise of a frame is a good part of its cost.
    for (std::size_t i = 0; i < count; i += 2) {
      const std::uint64_t bits = stream(key, 2 + i);
      const float u = (static_cast<float>(bits >> 40) + 0.5f) * 0x1p-24f;
      const float angle = static_cast<float>(bits & 0xffffff) * 0x1p-24f * 2 * std::numbers::pi_v<float>;
      const float radius = std::sqrt(-2 * std::log(u));
      lattice_[i] = radius * std::cos(angle);
      if (i + 1 < count) lattice_[i + 1] = radius * std::sin(angle);
    }
  }

  void row(int y, std::vector<float>* values) const {
    const Node& r = rows_[static_cast<std::size_t>(y)];
    const float* above = lattice_.data() + static_cast<std::size_t>(r.cell) * lattice_width_;
    const float* below = above + lattice_width_;
    for (std::size_t x = 0; x < columns_.size(); ++x) {
      const Node& c = columns_[x];
      (*values)[x] = r.first * (c.first * above[c.cell] + c.second * above[c.cell + 1]) +
                     r.second * (c.first * below[c.cell] + c.second * below[c.cell + 1]);
    }
  }

 private:
  struct Node {
    int cell;
    float first, second;  ///< weights of the two lattice points, their squares sum to 1
  };

  static std::vector<Node> make_axis(int size, double spacing, double offset) {
    std::vector<Node> axis;
    axis.reserve(static_cast<std::size_t>(size));
    for (int i = 0; i < size; ++i) {
      const double at = i / spacing + offset, share = at - std::floor(at);
      const double norm = std::hypot(share, 1 - share);
      axis.push_back({static_cast<int>(at), static_cast<float>((1 - share) / norm), static_cast<float>(share / norm)});
    }
    return axis;
  }

  std::vector<Node> columns_, rows_;
  std::size_t lattice_width_ = 0;
  std::vector<float> lattice_;
};

/// A smooth pattern of unit rms over an image: waves of half to two widths.
Image<float> smooth_pattern(std::uint64_t key, int width, int height) {
  constexpr int kWaves = 8;
  struct Wave {
    double x, y, phase;
  };
  Random random(key);
  std::array<Wave, kWaves> waves{};
  for (Wave& wave : waves) {
    const double azimuth = random.uniform(0, 2 * std::numbers::pi), cycles = random.uniform(0.5, 2);
    const double phase = random.uniform(0, 2 * std::numbers::pi), k = 2 * std::numbers::pi * cycles / width;
    wave = {k * std::cos(azimuth), k * std::sin(azimuth), phase};
  }
  Image<float> pattern(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      for (const Wave& wave : waves) sum += std::cos(wave.x * x + wave.y * y + wave.phase);
      pattern.at(x, y) = static_cast<float>(sum * std::sqrt(2.0 / kWaves));
    }
  }
  return pattern;
}

/// Share of the standard normal distribution below g.
double normal_share(double g) { return 0.5 * std::erfc(-g / std::numbers::sqrt2); }

/// The value below which this share of the standard normal distribution lies, within ±9.
double normal_quantile(double share) {
  double low = -9, high = 9;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (normal_share(middle) < share ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// What depends on the incidence alone, over its cosine: the formulas' arc cosines would be a third of a frame's time.
class IncidenceTable {
 public:
  struct Entry {
    float lateral = 0;     ///< pixels, standard deviation
    float slope_term = 0;  ///< axial deviation beyond that at right angles, metres · √metre
    float hole_limit = 0;  ///< no reading where the field of holes lies below
  };

  explicit IncidenceTable(const DepthNoise& noise) {
    for (int i = 0; i <= kSize; ++i) {
      const double incidence = std::acos(static_cast<double>(i) / kSize);
      entries_[static_cast<std::size_t>(i)] = {
          static_cast<float>(noise.lateral * lateral_sigma(incidence)),
          static_cast<float>(axial_sigma(1, incidence) - axial_sigma(1, 0)),
          static_cast<float>(normal_quantile(grazing_hole_rate(noise, incidence)))};
    }
  }

  Entry at(float cosine) const {
    const float position = std::clamp(cosine, 0.0f, 1.0f) * kSize;
    const auto i = std::min(static_cast<std::size_t>(position), static_cast<std::size_t>(kSize - 1));
    const float share = position - static_cast<float>(i);
    const Entry &a = entries_[i], &b = entries_[i + 1];
    return {a.lateral + share * (b.lateral - a.lateral), a.slope_term + share * (b.slope_term - a.slope_term),
            a.hole_limit + share * (b.hole_limit - a.hole_limit)};
  }

 private:
  static constexpr int kSize = 2048;
  std::array<Entry, kSize + 1> entries_;
};

/// Of each vertex, 0…1: the luminance of its colour in linear light (IEC 61966-2-1), for want of its infrared
/// reflectance; of a middle grey without colours.
std::vector<float> reflectances(const Mesh& mesh) {
  constexpr float kMiddleGrey = 0.21f;
  if (mesh.colors.size() != mesh.positions.size()) return std::vector<float>(mesh.positions.size(), kMiddleGrey);
  std::array<float, 256> linear{};
  for (std::size_t i = 0; i < linear.size(); ++i) {
    const float v = static_cast<float>(i) / 255;
    linear[i] = v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
  }
  std::vector<float> list;
  list.reserve(mesh.colors.size());
  for (const Mesh::Rgb& c : mesh.colors)
    list.push_back(0.2126f * linear[c.r] + 0.7152f * linear[c.g] + 0.0722f * linear[c.b]);
  return list;
}

float incidence_cosine(const Vector3f& normal, const Vector3f& ray) { return -normal.dot(ray) / ray.norm(); }

void validate(const DepthCameraOptions& o) {
  const DepthNoise& n = o.model;
  if (!o.camera.is_valid())
    throw Error("the camera's intrinsics are not valid", kDepthCameraWhere, "give a positive size and fx");
  if (!(o.depth_scale > 0))
    throw Error("the depth scale is not positive", kDepthCameraWhere, "give readings per metre");
  if (!(o.readout >= 0) || !(o.exposure >= 0) || o.exposure_samples < 1 || o.exposure_samples > 64)
    throw Error("a shutter time is out of range", kDepthCameraWhere,
                "give seconds from 0 and 1 to 64 exposure samples");
  if (!(n.axial >= 0) || !(n.lateral >= 0) || !(n.baseline > 0) || !(n.focal_length > 0) || !(n.disparity_step >= 0) ||
      !(n.correlation >= 1) || !(n.distortion >= 0) || !(n.min_range >= 0) || !(n.max_range > n.min_range) ||
      !(n.signal >= 0) || !(n.edge_holes >= 0) || !(n.edge_holes <= 1) || !(n.grazing_end > n.grazing_start))
    throw Error("a value of the noise model is out of range", kDepthCameraWhere,
                "give factors from 0, positive lengths, and ranges in ascending order");
}

}  // namespace

double axial_sigma(double z, double incidence) {
  const double theta = std::clamp(incidence, 0.0, kSteepest);
  const double slope = theta * theta / ((kHalfPi - theta) * (kHalfPi - theta));
  return 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4) + 0.0001 / std::sqrt(z) * slope;
}

double lateral_sigma(double incidence) {
  const double theta = std::clamp(incidence, 0.0, kSteepest);
  return 0.8 + 0.035 * theta / (kHalfPi - theta);
}

double grazing_hole_rate(const DepthNoise& noise, double incidence) {
  return std::clamp((incidence - noise.grazing_start) / (noise.grazing_end - noise.grazing_start), 0.0, 1.0);
}

class DepthCamera::Implementation {
 public:
  Implementation(const Mesh& mesh, const DepthCameraOptions& options)
      : options_(options),
        mesh_{mesh.positions, {}, mesh.colors, mesh.triangles},
        reflectance_(reflectances(mesh)),
        device_(embree::make_device()),
        scene_(embree::make_scene(device_.get(), mesh_, kDepthCameraWhere)),
        incidence_(options.model),
        distortion_(smooth_pattern(stream(options.seed, kDistortion), options.camera.width, options.camera.height)) {}

  Frame capture(const PoseAt& pose_at, double seconds, int index) const;

 private:
  void look(const PoseAt& pose_at, double seconds, SightImage* sight, std::vector<std::uint16_t>* color) const;
  void look_along_row(const SE3& world_from_camera, int y, SightImage* sight, std::vector<std::uint16_t>* color) const;
  void add_color(const RTCRayHit8& hits, int lane, std::uint16_t* rgb) const;
  float reflectance(const RTCRayHit8& hits, int lane) const;
  SightImage merge(const std::vector<SightImage>& instants, std::uint64_t key) const;
  DepthImage measure(const SightImage& sight, std::uint64_t key) const;
  DepthImage exact(const SightImage& sight) const;
  std::vector<std::uint8_t> shadow(const SightImage& sight) const;
  float measure_pixel(const Sight& sight, int x, int y, float deviate, float hole_field) const;
  Sight shifted(const SightImage& sight, int x, int y, float shift_x, float shift_y, bool* in_shadow,
                const std::vector<std::uint8_t>& shadow) const;
  Vector3f ray(int x, int y) const {
    const Pinhole& k = options_.camera;
    return {(static_cast<float>(x) - k.cx) / k.fx, (static_cast<float>(y) - k.cy) / k.fy, 1.0f};
  }

  DepthCameraOptions options_;
  Mesh mesh_;
  std::vector<float> reflectance_;  ///< of each vertex
  embree::Device device_;
  embree::Scene scene_;
  IncidenceTable incidence_;
  Image<float> distortion_;  ///< unit rms
};

// ---- seeing

void DepthCamera::Implementation::add_color(const RTCRayHit8& hits, int lane, std::uint16_t* rgb) const {
  constexpr std::uint16_t kGrey = 128;
  if (mesh_.colors.size() != mesh_.positions.size()) {
    for (int c = 0; c < 3; ++c) rgb[c] = static_cast<std::uint16_t>(rgb[c] + kGrey);
    return;
  }
  const Mesh::Triangle& t = mesh_.triangles[hits.hit.primID[lane]];
  const Mesh::Rgb &p = mesh_.colors[t.a], &q = mesh_.colors[t.b], &r = mesh_.colors[t.c];
  const float u = hits.hit.u[lane], v = hits.hit.v[lane], w = 1 - u - v;
  const auto mix = [&](std::uint8_t a, std::uint8_t b, std::uint8_t c) {
    return static_cast<std::uint16_t>(w * static_cast<float>(a) + u * static_cast<float>(b) +
                                      v * static_cast<float>(c) + 0.5f);
  };
  rgb[0] = static_cast<std::uint16_t>(rgb[0] + mix(p.r, q.r, r.r));
  rgb[1] = static_cast<std::uint16_t>(rgb[1] + mix(p.g, q.g, r.g));
  rgb[2] = static_cast<std::uint16_t>(rgb[2] + mix(p.b, q.b, r.b));
}

float DepthCamera::Implementation::reflectance(const RTCRayHit8& hits, int lane) const {
  const Mesh::Triangle& t = mesh_.triangles[hits.hit.primID[lane]];
  const float u = hits.hit.u[lane], v = hits.hit.v[lane];
  return (1 - u - v) * reflectance_[t.a] + u * reflectance_[t.b] + v * reflectance_[t.c];
}

void DepthCamera::Implementation::look_along_row(const SE3& world_from_camera, int y, SightImage* sight,
                                                 std::vector<std::uint16_t>* color) const {
  const int width = options_.camera.width;
  const Eigen::Matrix3f rotation = world_from_camera.rotation().cast<float>();
  const Vector3f origin = world_from_camera.translation().cast<float>();
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  for (int x0 = 0; x0 < width; x0 += kPacket) {
    alignas(32) std::array<int, kPacket> valid{};
    RTCRayHit8 hits{};
    for (int i = 0; i < kPacket; ++i) {
      valid[static_cast<std::size_t>(i)] = x0 + i < width ? -1 : 0;
      // A direction with z = 1 in the camera's frame makes the ray's parameter the depth itself.
      const Vector3f d = rotation * ray(x0 + i, y);
      hits.ray.org_x[i] = origin.x();
      hits.ray.org_y[i] = origin.y();
      hits.ray.org_z[i] = origin.z();
      hits.ray.dir_x[i] = d.x();
      hits.ray.dir_y[i] = d.y();
      hits.ray.dir_z[i] = d.z();
      hits.ray.tfar[i] = std::numeric_limits<float>::infinity();
      hits.ray.mask[i] = ~0U;
      hits.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect8(valid.data(), scene_.get(), &context, &hits);
    for (int i = 0; i < kPacket && x0 + i < width; ++i) {
      if (hits.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
      const Vector3f facet(hits.hit.Ng_x[i], hits.hit.Ng_y[i], hits.hit.Ng_z[i]);
      Vector3f normal = (rotation.transpose() * facet).normalized();
      if (normal.dot(ray(x0 + i, y)) > 0) normal = -normal;
      sight->at(x0 + i, y) = {hits.ray.tfar[i], reflectance(hits, i), normal};
      if (color != nullptr) add_color(hits, i, color->data() + 3 * (static_cast<std::size_t>(y) * width + x0 + i));
    }
  }
}

/// One instant of the exposure; rows follow one another in the readout.
void DepthCamera::Implementation::look(const PoseAt& pose_at, double seconds, SightImage* sight,
                                       std::vector<std::uint16_t>* color) const {
  const int height = options_.camera.height;
  SE3 pose = pose_at(seconds);
  for (int y = 0; y < height; ++y) {
    if (options_.readout > 0) pose = pose_at(seconds + options_.readout * ((y + 0.5) / height - 0.5));
    look_along_row(pose, y, sight, color);
  }
}

/// Where the instants of the exposure see one surface the light adds up to its mean; where they see several, the
/// pattern of one of them is matched, and neighbouring pixels mostly agree on which.
SightImage DepthCamera::Implementation::merge(const std::vector<SightImage>& instants, std::uint64_t key) const {
  SightImage merged = instants[instants.size() / 2];
  const SmoothField choice(stream(key, kInstant), merged.width, merged.height, options_.model.correlation);
  std::vector<float> field(static_cast<std::size_t>(merged.width));
  for (int y = 0; y < merged.height; ++y) {
    choice.row(y, &field);
    for (int x = 0; x < merged.width; ++x) {
      float low = std::numeric_limits<float>::infinity(), high = 0, sum = 0;
      for (const SightImage& instant : instants) {
        const float z = instant.at(x, y).z;
        low = std::min(low, z);
        high = std::max(high, z);
        sum += z;
      }
      if (high <= 0) continue;
      if (low > 0 && high - low < kEdge * low) {
        merged.at(x, y).z = sum / static_cast<float>(instants.size());
        continue;
      }
      const double share = normal_share(static_cast<double>(field[static_cast<std::size_t>(x)]));
      const auto k = static_cast<std::size_t>(share * static_cast<double>(instants.size()));
      merged.at(x, y) = instants[std::min(k, instants.size() - 1)].at(x, y);
    }
  }
  return merged;
}

// ---- measuring

/// Pixels that the projector, `baseline` to the right of the camera, does not light. Along a row a point at column u is
/// lit from column u − f·b/z of the projector; a surface farther right that is lit from that column or one beyond it
/// stands in the way.
std::vector<std::uint8_t> DepthCamera::Implementation::shadow(const SightImage& sight) const {
  constexpr float kTolerance = 0.25f;  // pixels
  std::vector<std::uint8_t> dark(sight.pixels.size());
  if (!options_.model.shadow) return dark;
  const float scale = options_.camera.fx * static_cast<float>(options_.model.baseline);
  for (int y = 0; y < sight.height; ++y) {
    float nearest = std::numeric_limits<float>::infinity();
    for (int x = sight.width - 1; x >= 0; --x) {
      const float z = sight.at(x, y).z;
      if (z <= 0) continue;
      const float column = static_cast<float>(x) - scale / z;
      dark[static_cast<std::size_t>(y) * sight.width + x] = column > nearest + kTolerance ? 1 : 0;
      nearest = std::min(nearest, column);
    }
  }
  return dark;
}

/// The surface that is matched at (x, y): that of a pixel nearby, continued as a plane to this pixel's ray, so that
/// edges move and flat surfaces stay.
Sight DepthCamera::Implementation::shifted(const SightImage& sight, int x, int y, float shift_x, float shift_y,
                                           bool* in_shadow, const std::vector<std::uint8_t>& shadow) const {
  const Sight& own = sight.at(x, y);
  const float sigma = incidence_.at(own.z > 0 ? incidence_cosine(own.normal, ray(x, y)) : 1.0f).lateral;
  const int qx = std::clamp(static_cast<int>(std::lround(static_cast<float>(x) + sigma * shift_x)), 0, sight.width - 1);
  const int qy =
      std::clamp(static_cast<int>(std::lround(static_cast<float>(y) + sigma * shift_y)), 0, sight.height - 1);
  Sight found = sight.at(qx, qy);
  *in_shadow = shadow[static_cast<std::size_t>(qy) * sight.width + qx] != 0;
  if (found.z <= 0 || (qx == x && qy == y)) return found;
  const float here = found.normal.dot(ray(x, y)), there = found.normal.dot(ray(qx, qy));
  const float continued = found.z * there / here;
  if (here < 0 && std::abs(continued - found.z) < kEdge * found.z) found.z = continued;
  return found;
}

/// Metres, or 0 for none: noise of the given unit deviate on the disparity, then rounding to its steps.
float DepthCamera::Implementation::measure_pixel(const Sight& sight, int x, int y, float deviate,
                                                 float hole_field) const {
  const DepthNoise& n = options_.model;
  const double z = static_cast<double>(sight.z);
  if (!(z > 0) || z < n.min_range || z > n.max_range) return 0;
  const float cosine = incidence_cosine(sight.normal, ray(x, y));
  const IncidenceTable::Entry incidence = incidence_.at(cosine);
  if (hole_field < incidence.hole_limit) return 0;
  // Borders of dark things are ragged: 30 % more or less light makes the difference there.
  const double needed = n.signal * z * z * static_cast<double>(1 + 0.3f * hole_field);
  if (static_cast<double>(sight.reflectance * cosine) < needed) return 0;
  const double product = n.focal_length * n.baseline;
  const double deviation = axial_sigma(z, 0) + static_cast<double>(incidence.slope_term) / std::sqrt(z);
  // What rounding adds belongs to the deviation that was measured on real sensors.
  const double wanted = n.axial * deviation * product / (z * z), step = n.disparity_step;
  const double sigma = std::sqrt(std::max(0.0, wanted * wanted - step * step / 12));
  double disparity =
      product / z + n.distortion * static_cast<double>(distortion_.at(x, y)) + sigma * static_cast<double>(deviate);
  if (step > 0) disparity = std::round(disparity / step) * step;
  if (!(disparity > 0)) return 0;
  const double measured = product / disparity;
  return measured < n.min_range || measured > n.max_range ? 0 : static_cast<float>(measured);
}

DepthImage DepthCamera::Implementation::measure(const SightImage& sight, std::uint64_t key) const {
  const int width = sight.width, height = sight.height;
  const double spacing = options_.model.correlation;
  const std::vector<std::uint8_t> dark = shadow(sight);
  const SmoothField axial(stream(key, kAxial), width, height, spacing),
      shift_x(stream(key, kShiftX), width, height, spacing), shift_y(stream(key, kShiftY), width, height, spacing),
      holes(stream(key, kHoles), width, height, spacing);
  const std::uint64_t edge_key = stream(key, kEdges);
  std::vector<float> deviate(static_cast<std::size_t>(width)), dx = deviate, dy = deviate, hole = deviate;
  DepthImage depth(width, height);
  const auto is_edge = [&](int x, int y) {
    const float z = sight.at(x, y).z;
    const auto differs = [&](int u, int v) {
      if (u < 0 || v < 0 || u >= width || v >= height) return false;
      const float other = sight.at(u, v).z;
      return std::abs(other - z) > kEdge * std::min(other, z);
    };
    return differs(x - 1, y) || differs(x + 1, y) || differs(x, y - 1) || differs(x, y + 1);
  };
  for (int y = 0; y < height; ++y) {
    axial.row(y, &deviate);
    shift_x.row(y, &dx);
    shift_y.row(y, &dy);
    holes.row(y, &hole);
    for (int x = 0; x < width; ++x) {
      const auto i = static_cast<std::size_t>(x);
      bool in_shadow = false;
      const Sight matched = shifted(sight, x, y, dx[i], dy[i], &in_shadow, dark);
      if (in_shadow) continue;
      if (is_edge(x, y) && uniform_at(edge_key, static_cast<std::uint64_t>(y) * width + i) < options_.model.edge_holes)
        continue;
      const double reading =
          static_cast<double>(measure_pixel(matched, x, y, deviate[i], hole[i])) * options_.depth_scale + 0.5;
      if (reading < 65536) depth.at(x, y) = static_cast<std::uint16_t>(reading);
    }
  }
  return depth;
}

DepthImage DepthCamera::Implementation::exact(const SightImage& sight) const {
  DepthImage depth(sight.width, sight.height);
  for (std::size_t i = 0; i < depth.pixels.size(); ++i) {
    const double reading = static_cast<double>(sight.pixels[i].z) * options_.depth_scale + 0.5;
    if (reading < 65536) depth.pixels[i] = static_cast<std::uint16_t>(reading);
  }
  return depth;
}

Frame DepthCamera::Implementation::capture(const PoseAt& pose_at, double seconds, int index) const {
  const int width = options_.camera.width, height = options_.camera.height;
  const int count = options_.exposure > 0 ? options_.exposure_samples : 1;
  const std::uint64_t key = stream(stream(options_.seed, 0x63616d), static_cast<std::uint64_t>(index));
  std::vector<std::uint16_t> color(options_.color ? static_cast<std::size_t>(width) * height * 3 : 0);
  std::vector<SightImage> instants(static_cast<std::size_t>(count), SightImage(width, height));
  for (int k = 0; k < count; ++k)
    look(pose_at, seconds + options_.exposure * ((k + 0.5) / count - 0.5), &instants[static_cast<std::size_t>(k)],
         options_.color ? &color : nullptr);
  const SightImage sight = count > 1 ? merge(instants, key) : std::move(instants.front());

  Frame frame;
  frame.index = index;
  frame.depth_scale = options_.depth_scale;
  frame.depth = options_.noise ? measure(sight, key) : exact(sight);
  if (!options_.color) return frame;
  frame.color = ColorImage(width, height, 3);
  for (std::size_t i = 0; i < color.size(); ++i)
    frame.color.pixels[i] = static_cast<std::uint8_t>((color[i] + count / 2) / count);
  return frame;
}

DepthCamera::DepthCamera(const Mesh& mesh, const DepthCameraOptions& options) : options_(options) {
  validate(options);
  implementation_ = std::make_unique<Implementation>(mesh, options);
}
DepthCamera::~DepthCamera() = default;
DepthCamera::DepthCamera(DepthCamera&&) noexcept = default;
DepthCamera& DepthCamera::operator=(DepthCamera&&) noexcept = default;

Frame DepthCamera::capture(const PoseAt& world_from_camera, double seconds, int index) const {
  return implementation_->capture(world_from_camera, seconds, index);
}

Frame DepthCamera::capture(const SE3& world_from_camera, int index) const {
  return implementation_->capture([&](double) { return world_from_camera; }, 0, index);
}

}  // namespace plumbline::sim
