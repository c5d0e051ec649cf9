// Furniture and things, of which the scenes are made. Each stands with its foot at the pose's origin, z up, its front
// towards local −y unless said otherwise. Lengths in metres.
#pragma once

#include "core/random.h"
#include "plumbline/mesh.h"
#include "plumbline/se3.h"
#include "sim/mesh_builder.h"

namespace plumbline::sim::props {

// ---- rooms

/// Floor, ceiling and four walls about the origin, |x| ≤ half.x, |y| ≤ half.y, 0 ≤ z ≤ height, with skirting boards.
void room(MeshBuilder& m, const Eigen::Vector2d& half, double height, const Paint& floor, const Paint& wall);
/// In the wall behind it: the pose lies on the wall, local −y faces the room.
void window(MeshBuilder& m, const SE3& pose, double width, double height);
void curtain(MeshBuilder& m, const SE3& pose, double width, double height, Mesh::Rgb color);
void door(MeshBuilder& m, const SE3& pose);
void picture(MeshBuilder& m, const SE3& pose, double width, double height, std::uint64_t key);
void radiator(MeshBuilder& m, const SE3& pose, double width);
void ceiling_lamp(MeshBuilder& m, const SE3& pose);

// ---- furniture

/// `half` is of the top; `height` to its upper side.
void table(MeshBuilder& m, const SE3& pose, const Eigen::Vector2d& half, double height, const Paint& top);
void office_chair(MeshBuilder& m, const SE3& pose, Mesh::Rgb cloth);
void kitchen_chair(MeshBuilder& m, const SE3& pose);
void sofa(MeshBuilder& m, const SE3& pose, double width, Mesh::Rgb cloth);
/// Open shelves with books and small objects on them.
void bookcase(MeshBuilder& m, const SE3& pose, double width, double height, int shelves, std::uint64_t key);
/// A board on brackets with things on it; the pose is on the wall at the board's height.
void wall_shelf(MeshBuilder& m, const SE3& pose, double width, std::uint64_t key);
/// Drawers with handles.
void cabinet(MeshBuilder& m, const SE3& pose, const Eigen::Vector3d& half, int drawers, Mesh::Rgb front);
void rug(MeshBuilder& m, const SE3& pose, const Eigen::Vector2d& half, Mesh::Rgb a, Mesh::Rgb b);

// ---- things

void monitor(MeshBuilder& m, const SE3& pose);
void laptop(MeshBuilder& m, const SE3& pose);
void keyboard(MeshBuilder& m, const SE3& pose);
void mouse(MeshBuilder& m, const SE3& pose);
void telephone(MeshBuilder& m, const SE3& pose);
void desk_lamp(MeshBuilder& m, const SE3& pose, Mesh::Rgb color);
void cup(MeshBuilder& m, const SE3& pose, Mesh::Rgb color);
void bottle(MeshBuilder& m, const SE3& pose, Mesh::Rgb color);
void vase(MeshBuilder& m, const SE3& pose, Mesh::Rgb color);
void bowl_of_fruit(MeshBuilder& m, const SE3& pose, std::uint64_t key);
void plate(MeshBuilder& m, const SE3& pose, double radius);
void pen_holder(MeshBuilder& m, const SE3& pose, std::uint64_t key);
void book(MeshBuilder& m, const SE3& pose, const Eigen::Vector3d& half, Mesh::Rgb cover);
/// Lying on one another.
void book_stack(MeshBuilder& m, const SE3& pose, int count, std::uint64_t key);
/// Standing side by side along local x; returns the length taken.
double book_row(MeshBuilder& m, const SE3& pose, double length, std::uint64_t key);
void open_book(MeshBuilder& m, const SE3& pose);
void papers(MeshBuilder& m, const SE3& pose, std::uint64_t key);
void box_carton(MeshBuilder& m, const SE3& pose, const Eigen::Vector3d& half);
void globe(MeshBuilder& m, const SE3& pose);
void plant(MeshBuilder& m, const SE3& pose, double height, std::uint64_t key);
void teddy(MeshBuilder& m, const SE3& pose, double height, Mesh::Rgb fur);
void waste_bin(MeshBuilder& m, const SE3& pose);
void computer_tower(MeshBuilder& m, const SE3& pose);
void ball(MeshBuilder& m, const SE3& pose, double radius, Mesh::Rgb a, Mesh::Rgb b);
void pot(MeshBuilder& m, const SE3& pose, double radius, double height, Mesh::Rgb color);
void kettle(MeshBuilder& m, const SE3& pose);
void tap(MeshBuilder& m, const SE3& pose);
/// One of several small things, by chance.
void trinket(MeshBuilder& m, const SE3& pose, Random& random);

}  // namespace plumbline::sim::props
