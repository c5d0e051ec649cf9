#include "sim/mesh_renderer.h"

#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "core/embree_scene.h"
#include "plumbline/error.h"
#include "plumbline/image.h"
#include "plumbline/mesh.h"
#include "plumbline/trajectory.h"
#include "sim/analytic_scene.h"

namespace plumbline::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr const char* kMeshRendererWhere = "mesh renderer";
constexpr int kTile = 32;
/// Neighbouring pixels use different rotations of the occlusion rays, all of them within each 4×4 block; the filter
/// of that size then averages them (interleaved sampling: Keller and Heidrich 2001).
constexpr int kInterleave = 4;

Vector3f to_vector(const Mesh::Float3& p) { return {p.x, p.y, p.z}; }

/// Point k of the R2 sequence, a low-discrepancy set in the unit square whose beginnings of any length are even
/// (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences").
Vector2d low_discrepancy(int k) {
  constexpr double kPlastic = 1.32471795724474602596;
  const double x = 0.5 + k / kPlastic, y = 0.5 + k / (kPlastic * kPlastic);
  return {x - std::floor(x), y - std::floor(y)};
}

/// Digits of k in base 2, mirrored at the point (van der Corput): even in [0, 1), and unrelated to the set above.
float radical_inverse(std::uint32_t k) {
  std::uint32_t bits = 0;
  for (int i = 0; i < 32; ++i) bits = (bits << 1) | ((k >> i) & 1U);
  return static_cast<float>(bits) * 0x1p-32f;
}

// ---- colour: computed in linear light, stored as sRGB (IEC 61966-2-1)

Vector3f to_linear(const Mesh::Rgb& c) {
  const auto channel = [](std::uint8_t v) {
    const float s = static_cast<float>(v) / 255.0f;
    return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
  };
  return {channel(c.r), channel(c.g), channel(c.b)};
}

std::uint8_t to_srgb(float linear) {
  const float v = std::clamp(linear, 0.0f, 1.0f);
  const float s = v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(std::lround(s * 255.0f));
}

Vector3f mix(const Vector3f& a, const Vector3f& b, float share) { return a + (b - a) * share; }

// ---- geometry

/// Vertex normals as the sum of the triangles' area vectors, for meshes that bring none.
std::vector<Mesh::Float3> smooth_normals(const Mesh& mesh) {
  std::vector<Vector3f> sums(mesh.positions.size(), Vector3f::Zero());
  for (const Mesh::Triangle& t : mesh.triangles) {
    const Vector3f a = to_vector(mesh.positions[t.a]);
    const Vector3f area = (to_vector(mesh.positions[t.b]) - a).cross(to_vector(mesh.positions[t.c]) - a);
    for (const std::uint32_t vertex : {t.a, t.b, t.c}) sums[vertex] += area;
  }
  std::vector<Mesh::Float3> normals;
  normals.reserve(sums.size());
  for (const Vector3f& n : sums) normals.push_back({n.x(), n.y(), n.z()});
  return normals;
}

/// Ends of the values' interval without a share at either side.
std::pair<float, float> robust_interval(std::vector<float> values, double share) {
  const auto rank = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
  const auto low = values.begin() + static_cast<std::ptrdiff_t>(rank);
  const auto high = values.end() - 1 - static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), low, values.end());
  const float low_value = *low;
  std::nth_element(values.begin(), high, values.end());
  return {low_value, *high};
}

double area(const Mesh& mesh, const Mesh::Triangle& t) {
  const Vector3f a = to_vector(mesh.positions[t.a]);
  const float twice = (to_vector(mesh.positions[t.b]) - a).cross(to_vector(mesh.positions[t.c]) - a).norm();
  return std::isfinite(twice) ? 0.5 * static_cast<double>(twice) : 0.0;
}

/// Points spread evenly over the mesh's area, from which its extent is judged: vertices would count a finely meshed
/// detail for more than a wide plane. Empty for a mesh without area.
/// Where two numbers of [0, 1) lie on a triangle, so that equal shares of them take equal areas (Turk 1990).
Vector3f point_on(const Mesh& mesh, const Mesh::Triangle& t, const Vector2d& s) {
  const float root = std::sqrt(static_cast<float>(s.x())), share = static_cast<float>(s.y());
  return (1 - root) * to_vector(mesh.positions[t.a]) + root * (1 - share) * to_vector(mesh.positions[t.b]) +
         root * share * to_vector(mesh.positions[t.c]);
}

std::vector<Vector3f> spread_points(const Mesh& mesh) {
  constexpr int kPoints = 20'000;
  double total = 0;
  for (const Mesh::Triangle& t : mesh.triangles) total += area(mesh, t);
  std::vector<Vector3f> points;
  if (!(total > 0)) return points;
  double sum = 0;
  for (const Mesh::Triangle& t : mesh.triangles) {
    sum += area(mesh, t);
    while (static_cast<double>(points.size()) + 0.5 < sum / total * kPoints) {
      points.push_back(point_on(mesh, t, low_discrepancy(static_cast<int>(points.size()))));
    }
  }
  return points;
}

std::vector<float> coordinates(const std::vector<Vector3f>& points, const Vector3f& direction) {
  std::vector<float> values;
  values.reserve(points.size());
  for (const Vector3f& p : points) values.push_back(p.dot(direction));
  return values;
}

/// Diagonal of the box around all but the outermost 1 % of the points along each axis, metres; 0 for no points.
double robust_size(const std::vector<Vector3f>& points) {
  if (points.empty()) return 0;
  Vector3d extent;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] = robust_interval(coordinates(points, Vector3f::Unit(axis)), 0.01);
    extent[axis] = static_cast<double>(high) - static_cast<double>(low);
  }
  return extent.norm();
}

/// A chain of round cones through the camera centres; a null scene where there are fewer than two distinct ones.
embree::Scene make_tube(RTCDevice device, const Trajectory& path, float radius) {
  struct Knot {
    float x, y, z, radius;
  };
  std::vector<Knot> knots;
  for (const StampedPose& pose : path) {
    const Vector3f p = pose.world_from_camera.translation().cast<float>();
    if (!p.allFinite()) continue;
    if (!knots.empty() && (Vector3f(knots.back().x, knots.back().y, knots.back().z) - p).norm() < 0.1f * radius)
      continue;
    knots.push_back({p.x(), p.y(), p.z(), radius});
  }
  if (knots.size() < 2) return nullptr;
  std::vector<std::uint32_t> segments(knots.size() - 1);
  for (std::size_t i = 0; i < segments.size(); ++i) segments[i] = static_cast<std::uint32_t>(i);

  embree::Scene scene(rtcNewScene(device));
  const embree::Geometry tube(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE));
  embree::set_buffer(tube.get(), RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, knots.data(), knots.size());
  embree::set_buffer(tube.get(), RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT, segments.data(), segments.size());
  rtcCommitGeometry(tube.get());
  rtcAttachGeometryByID(scene.get(), tube.get(), 0);
  rtcCommitScene(scene.get());
  embree::check(device, kMeshRendererWhere);
  return scene;
}

// ---- shading

/// What the rays of one pixel gather. Ambient light is kept apart, as the occlusion is filtered before it is applied.
struct Pixel {
  Vector3f direct = Vector3f::Zero(), ambient = Vector3f::Zero();  ///< linear light, mean over the samples
  Vector3f normal = Vector3f::Zero();                              ///< sum over the samples
  float depth = 0;                                                 ///< metres along the rays, mean over the hits
  float openness = 0;  ///< share of the sky that is seen, mean over the hits
  float hits = 0;
};

/// Everything that stays the same over a picture.
struct Setting {
  Vector3f key, fill, up;  ///< unit directions towards the lights and the sky, world frame
  float occlusion_distance = 0, tube_segments = 1;
};

Setting make_setting(const SE3& world_from_camera, const RenderOptions& options, double size) {
  // The lights come with the camera: the key light over its left shoulder, the fill light from the right.
  const Eigen::Matrix3f r = world_from_camera.rotation().cast<float>();
  Setting s;
  s.key = (r * Vector3f(-0.55f, -0.75f, -0.75f)).normalized();
  s.fill = (r * Vector3f(0.80f, -0.10f, -0.60f)).normalized();
  s.up = options.up.normalized().cast<float>();
  s.occlusion_distance = static_cast<float>(options.occlusion_distance > 0 ? options.occlusion_distance : 0.25 * size);
  return s;
}

/// Where a ray meets the mesh.
struct SurfacePoint {
  Vector3f position, normal, facet_normal;  ///< normals are unit and face the viewer
  Vector3f albedo;                          ///< linear
  bool from_behind = false;
};

/// Blue to orange over the path, in linear light.
Vector3f path_color(float share) {
  const Vector3f start(0.02f, 0.16f, 0.55f), middle(0.45f, 0.10f, 0.35f), end(0.95f, 0.28f, 0.02f);
  return share < 0.5f ? mix(start, middle, 2 * share) : mix(middle, end, 2 * share - 1);
}

/// Orthonormal axes around a unit vector (Duff et al., "Building an orthonormal basis, revisited", 2017).
std::pair<Vector3f, Vector3f> axes_around(const Vector3f& n) {
  const float sign = std::copysign(1.0f, n.z());
  const float a = -1.0f / (sign + n.z()), b = n.x() * n.y() * a;
  return {Vector3f(1 + sign * n.x() * n.x() * a, sign * b, -sign * n.x()),
          Vector3f(b, sign + n.y() * n.y() * a, -n.y())};
}

void validate(const Pinhole& camera, const RenderOptions& o) {
  if (!camera.is_valid())
    throw Error("the camera's intrinsics are not valid", kMeshRendererWhere, "give a positive size and fx");
  if (o.samples < 1 || o.samples > 256 || o.occlusion_rays < 0 || o.occlusion_rays > 256) {
    throw Error("the number of rays is out of range", kMeshRendererWhere,
                "give 1 to 256 samples and 0 to 256 occlusion rays");
  }
  if (!(o.up.norm() > 0)) throw Error("the up direction is zero", kMeshRendererWhere, "give a direction");
}

}  // namespace

class MeshRenderer::Implementation {
 public:
  explicit Implementation(const Mesh& mesh)
      : mesh_(mesh),
        device_(embree::make_device()),
        scene_(embree::make_scene(device_.get(), mesh_, kMeshRendererWhere)),
        points_(spread_points(mesh_)),
        size_(robust_size(points_)) {
    if (mesh_.normals.size() != mesh_.positions.size()) mesh_.normals = smooth_normals(mesh_);
  }

  ColorImage render(const Pinhole& camera, const SE3& world_from_camera, const RenderOptions& options) const;
  SE3 default_view(const Pinhole& camera, const Vector3d& up, const Trajectory& path) const;

 private:
  /// One picture in the making.
  struct Job {
    const Pinhole& camera;
    const RenderOptions& options;
    Vector3f origin;
    Eigen::Matrix3f world_from_camera;
    Setting setting;
    embree::Scene tube;
  };

  Pixel trace_pixel(const Job& job, int x, int y) const;
  void add_sample(const Job& job, int x, int y, int sample, Pixel* pixel) const;
  void add_surface(const Job& job, const SurfacePoint& point, int rotation, int sample, Pixel* pixel) const;
  RTCRayHit first_hit(const Job& job, const Vector3f& direction) const;
  SurfacePoint surface_point(const Job& job, const RTCRayHit& hit) const;
  float openness(const Job& job, const SurfacePoint& point, int rotation, int sample) const;
  double visible_front(const Pinhole& camera, const SE3& world_from_camera) const;
  std::vector<Vector3f> scanned_from_near(const Trajectory& path) const;

  Mesh mesh_;
  embree::Device device_;
  embree::Scene scene_;
  std::vector<Vector3f> points_;  ///< a sample of the surface
  double size_;                   ///< metres
};

/// The nearest front face, or with back faces shown the nearest face.
RTCRayHit MeshRenderer::Implementation::first_hit(const Job& job, const Vector3f& direction) const {
  constexpr int kMaxLayers = 64;
  float near = 0;
  RTCRayHit hit{};
  for (int layer = 0; layer < kMaxLayers; ++layer) {
    hit = embree::intersect(scene_.get(), job.origin, direction, near);
    if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID || job.options.back_faces == BackFaces::darker) return hit;
    const Vector3f normal(hit.hit.Ng_x, hit.hit.Ng_y, hit.hit.Ng_z);
    if (normal.dot(direction) < 0) return hit;
    near = hit.ray.tfar * (1 + 1e-5f);
  }
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  return hit;
}

SurfacePoint MeshRenderer::Implementation::surface_point(const Job& job, const RTCRayHit& hit) const {
  const Mesh::Triangle& t = mesh_.triangles[hit.hit.primID];
  const float u = hit.hit.u, v = hit.hit.v, w = 1 - u - v;
  const Vector3f direction(hit.ray.dir_x, hit.ray.dir_y, hit.ray.dir_z);
  SurfacePoint p;
  p.position = job.origin + hit.ray.tfar * direction;
  p.facet_normal = Vector3f(hit.hit.Ng_x, hit.hit.Ng_y, hit.hit.Ng_z).normalized();
  p.from_behind = p.facet_normal.dot(direction) > 0;
  p.normal = w * to_vector(mesh_.normals[t.a]).stableNormalized() +
             u * to_vector(mesh_.normals[t.b]).stableNormalized() +
             v * to_vector(mesh_.normals[t.c]).stableNormalized();
  p.normal.normalize();
  if (p.from_behind) {
    p.facet_normal = -p.facet_normal;
    p.normal = -p.normal;
  }
  // An interpolated normal that faces away would light the surface from behind itself.
  if (!p.normal.allFinite() || p.normal.dot(direction) >= 0) p.normal = p.facet_normal;

  if (job.options.vertex_colors && mesh_.colors.size() == mesh_.positions.size()) {
    p.albedo = w * to_linear(mesh_.colors[t.a]) + u * to_linear(mesh_.colors[t.b]) + v * to_linear(mesh_.colors[t.c]);
  } else {
    const Vector3f tint = job.world_from_camera.transpose() * p.normal;
    p.albedo = to_linear(job.options.clay)
                   .cwiseProduct(Vector3f::Ones() + 0.10f * Vector3f(tint.x(), -0.3f * tint.y(), -tint.x()));
  }
  if (p.from_behind) p.albedo = 0.30f * mix(Vector3f::Constant(p.albedo.mean()), p.albedo, 0.6f);
  return p;
}

/// Share of cosine-weighted rays over the surface that meet nothing within the occlusion distance.
float MeshRenderer::Implementation::openness(const Job& job, const SurfacePoint& p, int rotation, int sample) const {
  const int rays = job.options.occlusion_rays;
  const float distance = job.setting.occlusion_distance;
  if (rays == 0 || !(distance > 0)) return 1;
  const auto [tangent, bitangent] = axes_around(p.normal);
  const Vector3f origin = p.position + p.facet_normal * (0.002f * distance);
  const Vector2d shift = low_discrepancy(rotation);
  int open = 0, cast = 0;
  for (int k = 0; k < rays; ++k) {
    // Cranley–Patterson rotation of one set for all pixels.
    const Vector2d s = low_discrepancy(sample * rays + k) + shift;
    const float phi = 2 * std::numbers::pi_v<float> * static_cast<float>(s.x() - std::floor(s.x()));
    const float sine2 = static_cast<float>(s.y() - std::floor(s.y()));
    const float sine = std::sqrt(sine2);
    const Vector3f direction =
        sine * std::cos(phi) * tangent + sine * std::sin(phi) * bitangent + std::sqrt(1 - sine2) * p.normal;
    if (direction.dot(p.facet_normal) <= 0) continue;  // below the facet, where only the normal was interpolated
    ++cast;
    // Rays of evenly spread lengths make a near occluder count for more than a far one.
    const float reach = distance * radical_inverse(static_cast<std::uint32_t>(sample * rays + k + 1));
    if (!embree::is_occluded(scene_.get(), origin, direction, reach)) ++open;
  }
  return cast == 0 ? 1.0f : static_cast<float>(open) / static_cast<float>(cast);
}

void MeshRenderer::Implementation::add_surface(const Job& job, const SurfacePoint& p, int rotation, int sample,
                                               Pixel* pixel) const {
  const Setting& s = job.setting;
  const float key = std::max(0.0f, p.normal.dot(s.key)), fill = std::max(0.0f, p.normal.dot(s.fill));
  const float sky = 0.5f + 0.5f * p.normal.dot(s.up);
  const Vector3f ground(0.42f, 0.40f, 0.39f), zenith(0.62f, 0.64f, 0.68f);
  const Vector3f direct = 0.56f * key * Vector3f(1.0f, 0.98f, 0.94f) + 0.14f * fill * Vector3f(0.92f, 0.96f, 1.0f);
  pixel->direct += p.albedo.cwiseProduct(direct);
  pixel->ambient += p.albedo.cwiseProduct(mix(ground, zenith, sky));
  pixel->normal += p.normal;
  pixel->depth += (p.position - job.origin).norm();
  pixel->openness += openness(job, p, rotation, sample);
  pixel->hits += 1;
}

void MeshRenderer::Implementation::add_sample(const Job& job, int x, int y, int sample, Pixel* pixel) const {
  const Pinhole& k = job.camera;
  const Vector2d offset = low_discrepancy(sample);
  const Vector3d ray((x - 0.5 + offset.x() - double{k.cx}) / k.fx, (y - 0.5 + offset.y() - double{k.cy}) / k.fy, 1);
  const Vector3f direction = (job.world_from_camera * ray.cast<float>()).normalized();
  const RTCRayHit hit = first_hit(job, direction);
  if (job.tube) {
    const RTCRayHit tube = embree::intersect(job.tube.get(), job.origin, direction, 0);
    if (tube.hit.geomID != RTC_INVALID_GEOMETRY_ID && tube.ray.tfar < hit.ray.tfar) {
      const Vector3f normal = Vector3f(tube.hit.Ng_x, tube.hit.Ng_y, tube.hit.Ng_z).normalized();
      const float share = (static_cast<float>(tube.hit.primID) + tube.hit.u) / job.setting.tube_segments;
      pixel->direct += path_color(share) * (0.45f + 0.75f * std::abs(normal.dot(direction)));
      return;
    }
  }
  if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
    const float height = (static_cast<float>(y) + static_cast<float>(offset.y())) / static_cast<float>(k.height);
    pixel->direct += mix(to_linear(job.options.background_top), to_linear(job.options.background_bottom), height);
    return;
  }
  const int rotation = (y % kInterleave) * kInterleave + x % kInterleave;
  add_surface(job, surface_point(job, hit), rotation, sample, pixel);
}

Pixel MeshRenderer::Implementation::trace_pixel(const Job& job, int x, int y) const {
  Pixel pixel;
  for (int sample = 0; sample < job.options.samples; ++sample) add_sample(job, x, y, sample, &pixel);
  const float share = 1.0f / static_cast<float>(job.options.samples);
  pixel.direct *= share;
  pixel.ambient *= share;
  if (pixel.hits > 0) {
    pixel.depth /= pixel.hits;
    pixel.openness /= pixel.hits;
    pixel.normal.normalize();
  }
  return pixel;
}

namespace {

/// Mean openness over the 4×4 pixels around that belong to the same surface.
float filtered_openness(const std::vector<Pixel>& pixels, int width, int height, int x, int y) {
  const auto at = [&](int u, int v) -> const Pixel& {
    return pixels[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)];
  };
  const Pixel& centre = at(x, y);
  float sum = 0, weight = 0;
  for (int v = std::max(0, y - 2); v < std::min(height, y + 2); ++v) {
    for (int u = std::max(0, x - 2); u < std::min(width, x + 2); ++u) {
      const Pixel& p = at(u, v);
      const bool same =
          p.hits > 0 && std::abs(p.depth - centre.depth) < 0.02f * centre.depth && p.normal.dot(centre.normal) > 0.8f;
      if (!same) continue;
      sum += p.openness * p.hits;
      weight += p.hits;
    }
  }
  return weight > 0 ? sum / weight : centre.openness;
}

void store(const Pixel& pixel, float openness, std::uint8_t* rgb) {
  // Light from a lamp also has its share of penumbra where little of the sky is seen.
  const Vector3f light = pixel.direct * (pixel.hits > 0 ? 0.55f + 0.45f * openness : 1.0f) + pixel.ambient * openness;
  for (int c = 0; c < 3; ++c) rgb[c] = to_srgb(light[c]);
}

template <class Body>
void for_each_pixel(int width, int height, const Body& body) {
  tbb::parallel_for(tbb::blocked_range2d<int>(0, height, kTile, 0, width, kTile), [&](const auto& tile) {
    for (int y = tile.rows().begin(); y < tile.rows().end(); ++y) {
      for (int x = tile.cols().begin(); x < tile.cols().end(); ++x) body(x, y);
    }
  });
}

}  // namespace

ColorImage MeshRenderer::Implementation::render(const Pinhole& camera, const SE3& world_from_camera,
                                                const RenderOptions& options) const {
  validate(camera, options);
  Job job{camera,
          options,
          world_from_camera.translation().cast<float>(),
          world_from_camera.rotation().cast<float>(),
          make_setting(world_from_camera, options, size_),
          nullptr};
  const double scanned = options.path.empty() ? 0 : robust_size(scanned_from_near(options.path));
  const double radius = options.path_radius > 0 ? options.path_radius : 0.003 * (scanned > 0 ? scanned : 1.0);
  job.tube = make_tube(device_.get(), options.path, static_cast<float>(radius));
  job.setting.tube_segments = static_cast<float>(std::max<std::size_t>(1, options.path.size() - 1));

  const int width = camera.width, height = camera.height;
  std::vector<Pixel> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for_each_pixel(width, height, [&](int x, int y) {
    pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] =
        trace_pixel(job, x, y);
  });
  ColorImage image(width, height, 3);
  for_each_pixel(width, height, [&](int x, int y) {
    const Pixel& pixel =
        pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    const float open = pixel.hits > 0 ? filtered_openness(pixels, width, height, x, y) : 1.0f;
    store(pixel, open, &image.at(x, y));
  });
  return image;
}

/// Share of a coarse picture that shows the free side, less twice what shows the other.
double MeshRenderer::Implementation::visible_front(const Pinhole& camera, const SE3& world_from_camera) const {
  constexpr int kColumns = 64, kRows = 48;
  const Vector3f origin = world_from_camera.translation().cast<float>();
  int score = 0;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const Vector3d ray(((column + 0.5) * camera.width / kColumns - 0.5 - double{camera.cx}) / camera.fx,
                         ((row + 0.5) * camera.height / kRows - 0.5 - double{camera.cy}) / camera.fy, 1);
      const Vector3f direction = (world_from_camera.rotation() * ray).normalized().cast<float>();
      const RTCRayHit hit = embree::intersect(scene_.get(), origin, direction, 0);
      if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
      score += Vector3f(hit.hit.Ng_x, hit.hit.Ng_y, hit.hit.Ng_z).dot(direction) < 0 ? 1 : -2;
    }
  }
  return static_cast<double>(score) / (kColumns * kRows);
}

/// Points up to 1.5 times the distance from the path within which most of what matters lies: a surface matters as much
/// as it fills a camera's image, which is by the inverse square of its distance.
std::vector<Vector3f> MeshRenderer::Implementation::scanned_from_near(const Trajectory& path) const {
  constexpr std::size_t kCameras = 64;
  constexpr float kNearest = 0.5f, kBeyond = 1.5f;  // metres, and of the distance
  constexpr double kShare = 0.65;
  std::vector<float> squares, ordered;
  const std::size_t step = (path.size() + kCameras - 1) / kCameras;
  for (const Vector3f& point : points_) {
    float square = std::numeric_limits<float>::max();
    for (std::size_t k = 0; k < path.size(); k += step)
      square = std::min(square, (point - path[k].world_from_camera.translation().cast<float>()).squaredNorm());
    squares.push_back(std::max(square, kNearest * kNearest));
  }
  ordered = squares;
  std::sort(ordered.begin(), ordered.end());
  double all = 0, sum = 0;
  for (const float square : ordered) all += 1 / double{square};
  float limit = 0;
  for (std::size_t i = 0; i < ordered.size() && sum < kShare * all; ++i) sum += 1 / double{limit = ordered[i]};
  std::vector<Vector3f> near;
  for (std::size_t i = 0; i < points_.size(); ++i)
    if (squares[i] <= kBeyond * kBeyond * limit) near.push_back(points_[i]);
  return near;
}

/// The camera with the given viewing direction that is nearest while all points but outliers are in the image.
SE3 fitted_view(const std::vector<Vector3f>& points, const Pinhole& camera, const Vector3d& towards_camera,
                const Vector3d& up) {
  constexpr double kOutliers = 0.001, kMargin = 0.92;
  const SE3 view = look_at(towards_camera, Vector3d::Zero(), up);
  const Eigen::Matrix3f axes = view.rotation().cast<float>();
  const double reach[2] = {kMargin * 0.5 * camera.width / camera.fx, kMargin * 0.5 * camera.height / camera.fy};
  // A point (x, z) along the camera's axes is in the image of an eye at (e, −d) where |x − e| ≤ reach · (z + d). Of all
  // points, the largest x − reach · z and the smallest x + reach · z decide.
  Vector3d eye = Vector3d::Zero();
  double distance = -std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 2; ++axis) {
    const Vector3f slope = static_cast<float>(reach[axis]) * axes.col(2);
    const double high = robust_interval(coordinates(points, axes.col(axis) - slope), kOutliers).second;
    const double low = robust_interval(coordinates(points, axes.col(axis) + slope), kOutliers).first;
    eye[axis] = (high + low) / 2;
    distance = std::max(distance, (high - low) / (2 * reach[axis]));
  }
  eye.z() = -distance;
  return {view.rotation(), view.rotation() * eye};
}

SE3 MeshRenderer::Implementation::default_view(const Pinhole& camera, const Vector3d& up,
                                               const Trajectory& path) const {
  RenderOptions options;
  options.up = up;
  validate(camera, options);
  if (camera.fy < 0) {
    throw Error("the camera's image is mirrored (fy is negative)", kMeshRendererWhere,
                "give a camera with a positive fy");
  }
  if (points_.empty()) return {};
  const std::vector<Vector3f> framed = path.empty() ? points_ : scanned_from_near(path);
  constexpr int kAzimuths = 16;
  constexpr double kElevation = 0.5, kFirstAzimuth = 0.6;  // radians
  const auto rotation = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), up.normalized());
  SE3 best;
  double best_score = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < kAzimuths; ++i) {
    const double azimuth = kFirstAzimuth + 2 * std::numbers::pi * i / kAzimuths;
    const Vector3d local(std::cos(azimuth) * std::cos(kElevation), std::sin(azimuth) * std::cos(kElevation),
                         std::sin(kElevation));
    const SE3 view = fitted_view(framed, camera, rotation * local, up);
    const double score = visible_front(camera, view);
    if (score <= best_score) continue;
    best = view;
    best_score = score;
  }
  return best;
}

MeshRenderer::MeshRenderer(const Mesh& mesh) : implementation_(std::make_unique<Implementation>(mesh)) {}
MeshRenderer::~MeshRenderer() = default;
MeshRenderer::MeshRenderer(MeshRenderer&&) noexcept = default;
MeshRenderer& MeshRenderer::operator=(MeshRenderer&&) noexcept = default;

ColorImage MeshRenderer::render(const Pinhole& camera, const SE3& world_from_camera,
                                const RenderOptions& options) const {
  return implementation_->render(camera, world_from_camera, options);
}

SE3 MeshRenderer::default_view(const Pinhole& camera, const Vector3d& up, const Trajectory& path) const {
  return implementation_->default_view(camera, up, path);
}

ColorImage render_mesh(const Mesh& mesh, const Pinhole& camera, const SE3& world_from_camera,
                       const RenderOptions& options) {
  return MeshRenderer(mesh).render(camera, world_from_camera, options);
}

SE3 default_view(const Mesh& mesh, const Pinhole& camera, const Vector3d& up) {
  return MeshRenderer(mesh).default_view(camera, up);
}

}  // namespace plumbline::sim
