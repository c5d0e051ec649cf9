// Owners of Embree's handles, the one way a mesh becomes a scene, and the questions that are asked of it. Header-only,
// so that `core` itself does not need Embree: a folder that includes it links `embree`.
#pragma once

#include <embree3/rtcore.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>

#include "plumbline/error.h"
#include "plumbline/mesh.h"

namespace plumbline::embree {

struct Release {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, Release>;
using Scene = std::unique_ptr<std::remove_pointer_t<RTCScene>, Release>;
using Geometry = std::unique_ptr<std::remove_pointer_t<RTCGeometry>, Release>;

/// Throws Error where Embree does not run on this processor.
inline Device make_device() {
  Device device(rtcNewDevice(nullptr));
  if (!device) {
    throw Error("Embree gives no device (code " + std::to_string(rtcGetDeviceError(nullptr)) + ")", "embree",
                "Embree needs an x86-64 processor with SSE2, or NEON");
  }
  return device;
}

/// Throws Error if the latest calls on the device failed, above all for want of memory.
inline void check(RTCDevice device, const std::string& where) {
  const RTCError code = rtcGetDeviceError(device);
  if (code == RTC_ERROR_NONE) return;
  throw Error(code == RTC_ERROR_OUT_OF_MEMORY ? "not enough memory for the search tree"
                                              : "Embree failed (code " + std::to_string(code) + ")",
              where, "use a smaller mesh");
}

/// Throws Error if a triangle names a vertex that is not there.
inline void check_indices(const Mesh& mesh, const std::string& where) {
  const std::size_t count = mesh.positions.size();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Mesh::Triangle& t = mesh.triangles[i];
    if (t.a < count && t.b < count && t.c < count) continue;
    throw Error("triangle " + std::to_string(i) + " names a vertex beyond the last of " + std::to_string(count), where,
                "check the mesh's faces");
  }
}

/// New buffer of a geometry, filled from an array. Embree pads its own buffers as its vector loads need; a shared one
/// would have to be padded by the caller.
template <class T>
void set_buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, const T* data, std::size_t count) {
  void* buffer = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(T), count);
  if (buffer != nullptr && count > 0) std::memcpy(buffer, data, sizeof(T) * count);
}

/// A committed scene of one triangle geometry (id 0) whose primitive ids are the triangles' indices. The mesh is
/// copied. Throws Error.
inline Scene make_scene(RTCDevice device, const Mesh& mesh, const std::string& where) {
  check_indices(mesh, where);
  Scene scene(rtcNewScene(device));
  const Geometry geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
  set_buffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, mesh.positions.data(), mesh.positions.size());
  set_buffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, mesh.triangles.data(), mesh.triangles.size());
  check(device, where);
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(scene.get(), geometry.get(), 0);
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  rtcCommitScene(scene.get());
  check(device, where);
  return scene;
}

inline RTCRayHit make_ray(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float near) {
  RTCRayHit r{};
  r.ray.org_x = origin.x();
  r.ray.org_y = origin.y();
  r.ray.org_z = origin.z();
  r.ray.dir_x = direction.x();
  r.ray.dir_y = direction.y();
  r.ray.dir_z = direction.z();
  r.ray.tnear = near;
  r.ray.tfar = std::numeric_limits<float>::infinity();
  r.ray.mask = ~0U;
  r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  return r;
}

/// The first surface beyond `near`, in lengths of `direction`; `hit.geomID` is RTC_INVALID_GEOMETRY_ID without one.
inline RTCRayHit intersect(RTCScene scene, const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                           float near = 0) {
  RTCRayHit ray = make_ray(origin, direction, near);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &ray);
  return ray;
}

/// Whether anything stops a ray within `distance`, in lengths of `direction`.
inline bool is_occluded(RTCScene scene, const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                        float distance) {
  RTCRay ray = make_ray(origin, direction, 0).ray;
  ray.tfar = distance;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &ray);
  return ray.tfar < 0;
}

namespace detail {

inline double squared_distance_to_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                          const Eigen::Vector3d& b) {
  const Eigen::Vector3d ab = b - a;
  const double length2 = ab.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
  return (a + t * ab - p).squaredNorm();
}

/// To the plane where the foot of the perpendicular falls inside, to the nearest edge otherwise; also right for
/// triangles without area.
inline double distance_to_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                   const Eigen::Vector3d& c) {
  const Eigen::Vector3d n = (b - a).cross(c - a);
  const bool inside =
      n.dot((b - a).cross(p - a)) >= 0 && n.dot((c - b).cross(p - b)) >= 0 && n.dot((a - c).cross(p - c)) >= 0;
  if (inside && n.squaredNorm() > 0) return std::abs(n.normalized().dot(p - a));
  return std::sqrt(std::min({squared_distance_to_segment(p, a, b), squared_distance_to_segment(p, b, c),
                             squared_distance_to_segment(p, c, a)}));
}

/// What Embree hands back for each triangle within the radius of a point query.
struct NearestTriangle {
  const Mesh* mesh;
  Eigen::Vector3d point;
  double best;

  static bool visit(RTCPointQueryFunctionArguments* arguments) {
    auto* query = static_cast<NearestTriangle*>(arguments->userPtr);
    const Mesh::Triangle& t = query->mesh->triangles[arguments->primID];
    const auto corner = [&](std::uint32_t i) {
      const Mesh::Float3& p = query->mesh->positions[i];
      return Eigen::Vector3d(p.x, p.y, p.z);
    };
    const double distance = distance_to_triangle(query->point, corner(t.a), corner(t.b), corner(t.c));
    if (distance >= query->best) return false;
    query->best = distance;
    // Rounded up, so that single precision does not shut out a triangle that is nearer still.
    arguments->query->radius = std::nextafter(static_cast<float>(distance), std::numeric_limits<float>::infinity());
    return true;
  }
};

}  // namespace detail

/// Metres from a point to the nearest triangle of the mesh that `scene` was made of, at most `limit`; in double.
inline double distance_to_mesh(RTCScene scene, const Mesh& mesh, const Eigen::Vector3d& point,
                               double limit = std::numeric_limits<double>::infinity()) {
  const Eigen::Vector3f centre = point.cast<float>();
  RTCPointQuery query{centre.x(), centre.y(), centre.z(), 0, static_cast<float>(limit)};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  detail::NearestTriangle state{&mesh, point, limit};
  rtcPointQuery(scene, &query, &context, &detail::NearestTriangle::visit, &state);
  return state.best;
}

}  // namespace plumbline::embree
