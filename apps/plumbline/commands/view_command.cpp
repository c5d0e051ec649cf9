#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "cli/browser.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "io/atomic_file.h"
#include "io/mesh.h"
#include "io/text_file.h"
#include "io/trajectory.h"
#include "plumbline/error.h"
#include "plumbline/mesh.h"
#include "report/report.h"

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;

struct PageArguments {
  std::string what, output;
  bool no_open = false;
};

/// Where pages of meshes lie until the next one of that name.
fs::path cached_page(const fs::path& mesh) { return fs::path(page_folder()) / (mesh.stem().string() + ".html"); }

std::string extent_text(const Mesh& mesh) {
  if (mesh.positions.empty()) return "nothing";
  Eigen::Vector3f low(mesh.positions[0].x, mesh.positions[0].y, mesh.positions[0].z), high = low;
  for (const Mesh::Float3& p : mesh.positions) {
    low = low.cwiseMin(Eigen::Vector3f(p.x, p.y, p.z));
    high = high.cwiseMax(Eigen::Vector3f(p.x, p.y, p.z));
  }
  const Eigen::Vector3f size = high - low;
  return fmt::format("{:.2f} × {:.2f} × {:.2f} m", size.x(), size.y(), size.z());
}

/// A page of a mesh alone, with the path that lies beside it, if one does.
std::string write_mesh_page(const fs::path& path, const std::string& output) {
  const Mesh mesh = read_mesh(path.string());
  Report report;
  report.title = path.filename().string();
  report.mesh = &mesh;
  report.facts = {{"Triangles", grouped(mesh.triangles.size()), ""},
                  {"Vertices", grouped(mesh.positions.size()), ""},
                  {"Extent", extent_text(mesh), "along x, y, z"}};
  report.details = {{"File", path.string(), ""}, {"Version", std::string("Plumbline ") + PLUMBLINE_VERSION, ""}};
  const fs::path trajectory = path.parent_path() / "trajectory.txt";
  if (fs::exists(trajectory)) report.path = read_trajectory(trajectory.string());
  const std::string page = output.empty() ? cached_page(path).string() : output;
  write_report(page, report);
  return page;
}

std::string copied(const fs::path& page, const std::string& output) {
  if (output.empty()) return page.string();
  write_file(output, read_file(page.string()));
  return output;
}

/// The page that shows `what`: the report of a run's folder, or a new page of a mesh.
std::string page_of(const PageArguments& arguments) {
  const fs::path path(arguments.what);
  if (!fs::is_directory(path)) {
    if (path.extension() == ".html") return copied(path, arguments.output);
    return write_mesh_page(path, arguments.output);
  }
  if (fs::exists(path / "report.html")) return copied(path / "report.html", arguments.output);
  if (fs::exists(path / "mesh.ply")) return write_mesh_page(path / "mesh.ply", arguments.output);
  throw Error("there is neither a report.html nor a mesh.ply", arguments.what,
              "Give the folder that `plumbline run` has written, or a mesh.");
}

int view(const PageArguments& arguments) {
  const std::string page = page_of(arguments);
  say("{}", page);
  if (!arguments.no_open) open_in_browser(page);
  return 0;
}

}  // namespace

void add_view_command(CLI::App& app, Command& chosen) {
  const auto arguments = std::make_shared<PageArguments>();
  CLI::App* command = app.add_subcommand("view", "Look at a run or a mesh in the browser");
  command->add_option("what", arguments->what, "Folder of a run, or a PLY or OBJ file")
      ->required()
      ->type_name("DIR|MESH");
  command->add_option("-o,--output", arguments->output, "Write the page here (default: a mesh's into the user's cache)")
      ->type_name("FILE");
  command->add_flag("--no-open", arguments->no_open, "Only write the page and say where");
  command->callback([arguments, &chosen] { chosen = [arguments] { return view(*arguments); }; });
}

}  // namespace plumbline::app
