// Pictures of meshes without a display: ray-traced, anti-aliased, with ambient occlusion.
//
// The picture is a function of the mesh, the view and the options alone: the same bits for any number of threads.
#pragma once

#include <memory>
#include <optional>

#include "plumbline/image.h"
#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"

namespace plumbline::sim {

/// What to show of triangles seen from behind (the side of no free space).
enum class BackFaces { darker, hidden };

struct RenderOptions {
  int samples = 8;                ///< rays a pixel, 1…256
  int occlusion_rays = 8;         ///< for each of them, 0…256; 0 = no ambient occlusion
  double occlusion_distance = 0;  ///< metres within which surfaces shade one another; 0 = a quarter of the mesh's size
  bool vertex_colors = true;      ///< where the mesh has them; otherwise clay
  Mesh::Rgb clay{206, 201, 194};  ///< tinted slightly by the normal
  BackFaces back_faces = BackFaces::darker;
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< world; the sky's side, for the ambient light
  Mesh::Rgb background_top{252, 252, 253}, background_bottom{222, 227, 233};
  Trajectory path;         ///< drawn as a tube through the cameras' centres, from blue to orange; may be empty
  double path_radius = 0;  ///< metres; 0 = 0.3 % of the size of what was scanned from near by
};

/// Holds the search tree of one mesh, for several pictures.
class MeshRenderer {
 public:
  /// Copies the mesh. Throws Error if a triangle names a vertex that is not there.
  explicit MeshRenderer(const Mesh& mesh);
  ~MeshRenderer();
  MeshRenderer(MeshRenderer&&) noexcept;
  MeshRenderer& operator=(MeshRenderer&&) noexcept;

  /// Throws Error if the camera or an option is not valid. Where the mesh is not, there is background.
  ColorImage render(const Pinhole& camera, const SE3& world_from_camera, const RenderOptions& options = {}) const;

  /// A three-quarter view from above that shows most of the surface's free side and fits the mesh into the image: of
  /// all but stray 0.1 % of its area at each side. With the `path` of the camera that scanned it, what was scanned from
  /// near by fills the image, and walls far behind may leave it. The identity for a mesh without area. Throws Error if
  /// the camera is not valid, its fy is negative, or `up` is zero.
  SE3 default_view(const Pinhole& camera, const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ(),
                   const Trajectory& path = {}) const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// One picture of one mesh: see MeshRenderer.
ColorImage render_mesh(const Mesh& mesh, const Pinhole& camera, const SE3& world_from_camera,
                       const RenderOptions& options = {});
SE3 default_view(const Mesh& mesh, const Pinhole& camera, const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ());

}  // namespace plumbline::sim
