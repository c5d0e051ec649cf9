// report.html: one page that needs nothing beside itself. What `plumbline run`, `demo` and `view` leave for people.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "plumbline/mesh.h"
#include "plumbline/trajectory.h"
#include "report/report_words.h"
#include "run/reconstruction.h"

namespace plumbline::app {

/// What the page shows. `run` and `mesh` must outlive it.
struct Report {
  std::string title;
  Verdict verdict;
  std::vector<std::string> remarks;     ///< sentences below the verdict
  std::vector<Fact> facts;              ///< the figures that are read first
  std::vector<Fact> details;            ///< the table at the end
  const Reconstruction* run = nullptr;  ///< none for a page of a mesh alone
  const Mesh* mesh = nullptr;           ///< or none
  Trajectory path;                      ///< beside a mesh without a run
  std::vector<double> surface_errors;   ///< metres, one a vertex of the mesh, or none
  double error_range = 0.02;            ///< metres that are red
};

/// Of a run, in words and figures.
Report report_of(const Reconstruction& run);

/// Whether the program holds the page (PLUMBLINE_REPORT).
bool can_report();

/// For `ReconstructionOptions::write_report`; none if the program has no page.
std::function<void(const std::string& path, const Reconstruction& run)> report_writer();

/// Throws Error if the program has no page or the file cannot be written whole. Meshes are decimated, and long runs
/// thinned, so that the file stays below 20 MB.
void write_report(const std::string& path, const Report& report);

}  // namespace plumbline::app
