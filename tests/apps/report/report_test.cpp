// The page itself is driven in a browser by web/test; here is what goes into it, and what happens without it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "plumbline/mesh.h"
#include "plumbline/se3.h"
#include "report/base64.h"
#include "report/report.h"
#include "report/report_frames.h"
#include "support/program.h"
#include "support/small_sequence.h"
#include "view/packed_mesh.h"

namespace plumbline::test {
namespace {

using app::PackedMesh;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// A wavy sheet of n by n vertices, one metre wide.
Mesh sheet(std::uint32_t n) {
  Mesh mesh;
  const auto step = 1.0f / static_cast<float>(n - 1);
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < n; ++j) {
      const float x = static_cast<float>(i) * step, y = static_cast<float>(j) * step;
      mesh.positions.push_back({x - 3, y, 0.05f * std::sin(9 * x)});
      mesh.normals.push_back({0, 0, 1});
      mesh.colors.push_back({static_cast<std::uint8_t>(255 * x), 10, 20});
      if (i + 1 < n && j + 1 < n) {
        const std::uint32_t a = i * n + j;
        mesh.triangles.push_back({a, a + n, a + 1});
        mesh.triangles.push_back({a + 1, a + n, a + n + 1});
      }
    }
  return mesh;
}

template <class T>
std::vector<std::array<T, 4>> decoded(const std::string& bytes, std::size_t count) {
  std::vector<std::array<T, 4>> values(count);
  EXPECT_EQ(meshopt_decodeVertexBuffer(values.data(), count, sizeof values[0],
                                       reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()),
            0);
  return values;
}

std::vector<Eigen::Vector3d> positions_of(const PackedMesh& packed) {
  std::vector<Eigen::Vector3d> positions;
  for (const auto& p : decoded<std::uint16_t>(packed.positions, packed.vertices))
    positions.push_back(packed.origin + packed.step * Eigen::Vector3d(p[0], p[1], p[2]));
  return positions;
}

double area(const std::vector<Eigen::Vector3d>& positions, const std::vector<std::uint32_t>& indices) {
  double sum = 0;
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
    const Eigen::Vector3d a = positions[indices[i]], b = positions[indices[i + 1]], c = positions[indices[i + 2]];
    sum += 0.5 * (b - a).cross(c - a).norm();
  }
  return sum;
}

std::vector<std::uint32_t> decoded_indices(const std::string& bytes, std::size_t triangles) {
  std::vector<std::uint32_t> indices(3 * triangles);
  EXPECT_EQ(meshopt_decodeIndexBuffer(indices.data(), indices.size(), sizeof indices[0],
                                      reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()),
            0);
  return indices;
}
std::vector<std::uint32_t> indices_of(const PackedMesh& packed) {
  return decoded_indices(packed.indices, packed.triangles);
}

TEST(PackMesh, KeepsASmallMeshAsItIs) {
  const Mesh mesh = sheet(20);
  std::vector<double> errors;
  for (const Mesh::Float3& p : mesh.positions) errors.push_back(0.01 * p.y);
  const PackedMesh packed = app::pack_mesh(mesh, errors, 0.01);
  ASSERT_EQ(packed.vertices, mesh.positions.size());
  ASSERT_EQ(packed.triangles, mesh.triangles.size());
  // The order may change, what belongs to a vertex stays with it: all of it follows from x and y.
  const std::vector<Eigen::Vector3d> positions = positions_of(packed);
  const auto colors = decoded<std::uint8_t>(packed.colors, packed.vertices),
             error_bytes = decoded<std::uint8_t>(packed.errors, packed.vertices);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Eigen::Vector3d& p = positions[i];
    EXPECT_NEAR(p.z(), 0.05 * std::sin(9 * (p.x() + 3)), 1e-4);
    EXPECT_NEAR(colors[i][0], 255 * (p.x() + 3), 1.1);
    EXPECT_NEAR(error_bytes[i][0], 255 * p.y(), 1.1);
  }
  EXPECT_EQ(decoded<std::int8_t>(packed.normals, packed.vertices)[7], (std::array<std::int8_t, 4>{0, 0, 127, 0}));
}

TEST(PackMesh, DecimatesToTheBudget) {
  const Mesh mesh = sheet(101);  // 20 000 triangles
  const PackedMesh whole = app::pack_mesh(mesh), packed = app::pack_mesh(mesh, {}, 1, 2000);
  EXPECT_LE(packed.triangles, 2000u);
  EXPECT_GE(packed.triangles, 1500u);
  EXPECT_LT(packed.vertices, 1300u);
  EXPECT_NEAR(area(positions_of(packed), indices_of(packed)), area(positions_of(whole), indices_of(whole)), 5e-3);
}

TEST(PackMesh, LooseTrianglesAndPointsHaveABudgetToo) {
  const Mesh connected = sheet(61);
  Mesh loose;  // a soup: no two triangles share a vertex
  for (const Mesh::Triangle& t : connected.triangles) {
    const auto first = static_cast<std::uint32_t>(loose.positions.size());
    for (const std::uint32_t i : {t.a, t.b, t.c}) loose.positions.push_back(connected.positions[i]);
    loose.triangles.push_back({first, first + 1, first + 2});
  }
  EXPECT_LE(app::pack_mesh(loose, {}, 1, 500).triangles, 2000u);
  Mesh points;
  points.positions.resize(app::kPointBudget + 1, {1, 2, std::nanf("")});
  const PackedMesh packed = app::pack_mesh(points);
  EXPECT_EQ(packed.triangles, 0u);
  EXPECT_EQ(packed.vertices, app::kPointBudget / 2 + 1);
  EXPECT_TRUE(positions_of(packed)[0].isApprox(Eigen::Vector3d(1, 2, 0)));
  EXPECT_EQ(app::pack_mesh(Mesh()).vertices, 0u);
}

/// Edges that one triangle alone has, by their vertices in order.
std::set<std::pair<std::uint32_t, std::uint32_t>> rim_of(const std::vector<std::uint32_t>& indices) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> counts;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const std::uint32_t a = indices[i], b = indices[i % 3 == 2 ? i - 2 : i + 1];
    ++counts[{std::min(a, b), std::max(a, b)}];
  }
  std::set<std::pair<std::uint32_t, std::uint32_t>> rim;
  for (const auto& [edge, count] : counts)
    if (count == 1) rim.insert(edge);
  return rim;
}

TEST(PackLevels, HasEverFewerTrianglesAndTheSameRim) {
  const app::MeshGrid grid{{-4, -1, -1}, 1e-4};
  const PackedMesh packed = app::pack_levels(sheet(41), {}, 1, grid);
  EXPECT_EQ(packed.origin, grid.origin) << "as for its neighbours";
  ASSERT_EQ(packed.level_triangles.size(), 3U);
  const std::vector<Eigen::Vector3d> positions = positions_of(packed);
  for (const Eigen::Vector3d& p : positions) EXPECT_NEAR(p.z(), 0.05 * std::sin(9 * (p.x() + 3)), 2e-4);
  const auto all = decoded_indices(packed.level_indices[0], packed.level_triangles[0]);
  EXPECT_EQ(packed.level_triangles[0], 3200U);
  for (std::size_t level = 1; level < 3; ++level) {
    EXPECT_LT(packed.level_triangles[level], packed.level_triangles[level - 1] / 2);
    const auto fewer = decoded_indices(packed.level_indices[level], packed.level_triangles[level]);
    EXPECT_EQ(rim_of(fewer), rim_of(all));
    EXPECT_NEAR(area(positions, fewer), area(positions, all), level == 1 ? 0.02 : 0.1);
  }
  EXPECT_TRUE(app::pack_levels(Mesh(), {}, 1, grid).level_triangles.empty());
}

TEST(Base64, IsRfc4648) {
  EXPECT_EQ(app::base64(""), "");
  EXPECT_EQ(app::base64("f"), "Zg==");
  EXPECT_EQ(app::base64("fo"), "Zm8=");
  EXPECT_EQ(app::base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(app::base64("\xff\xfe\xfd"), "//79");
}

/// Ten frames on a line, one metre a second; `lost` are without a pose.
app::Reconstruction straight_run(const std::vector<int>& lost) {
  app::Reconstruction run;
  for (int i = 0; i < 10; ++i) {
    FrameReport frame;
    frame.index = i;
    frame.time = from_seconds(0.1 * i);
    frame.world_from_camera = SE3(Eigen::Matrix3d::Identity(), {0.1 * i, 0, 0});
    const bool is_lost = std::find(lost.begin(), lost.end(), i) != lost.end();
    frame.tracking.status = is_lost ? TrackingStatus::lost : TrackingStatus::tracked;
    frame.tracking.reason = is_lost ? LostReason::few_inliers : LostReason::none;
    run.frames.push_back(frame);
    run.reads.emplace_back();
    if (!is_lost) run.trajectory.push_back({frame.time, frame.world_from_camera});
  }
  return run;
}

/// The truth is the same line, seen from another world and with a bump of `bump` metres at one frame.
void add_truth(app::Reconstruction* run, double bump) {
  const SE3 truth_from_world(so3::exp({0.3, -0.2, 0.5}), {4, 5, 6});
  for (int i = 0; i < 10; ++i)
    run->truth.push_back({from_seconds(0.1 * i),
                          truth_from_world * SE3(Eigen::Matrix3d::Identity(), {0.1 * i, i == 4 ? bump : 0.0, 0})});
  run->ate = eval::absolute_trajectory_error(run->truth, run->trajectory);
}

TEST(ReportWords, JudgeARun) {
  using Level = app::Verdict::Level;
  EXPECT_EQ(app::verdict_of(straight_run({})).text, "All 10 frames were tracked.");
  EXPECT_EQ(app::verdict_of(straight_run({})).level, Level::good);
  const app::Reconstruction lost = straight_run({3, 6, 7});
  EXPECT_EQ(app::verdict_of(lost).text, "3 of 10 frames were lost.");
  EXPECT_EQ(app::verdict_of(lost).level, Level::poor);
  EXPECT_THAT(app::remarks_of(lost).front(), HasSubstr("3 with too few matches. The longest gap: frames 6 to 7."));
  EXPECT_EQ(app::verdict_of(straight_run({3})).level, Level::fair);
  app::Reconstruction off = straight_run({});
  add_truth(&off, 0.3);
  EXPECT_EQ(app::verdict_of(off).level, Level::fair);
  EXPECT_THAT(app::remarks_of(off).front(), HasSubstr("0.40 s after the start"));
  app::Reconstruction broken = straight_run({});
  broken.failure = "depth/5.png: not a PNG file";
  EXPECT_EQ(app::verdict_of(broken).level, Level::poor);
  EXPECT_THAT(app::remarks_of(broken).front(), HasSubstr("depth/5.png"));
}

TEST(FrameTable, PutsTheTruthIntoTheEstimatesWorld) {
  app::Reconstruction run = straight_run({6});
  add_truth(&run, 0);
  const app::FrameTable table = app::frame_table(run);
  ASSERT_EQ(table.rows, 10u);
  ASSERT_EQ(table.values.size(), 10 * table.columns.size());
  const auto at = [&](const std::string& name, std::size_t row) {
    const auto column = std::find(table.columns.begin(), table.columns.end(), name) - table.columns.begin();
    return table.values[static_cast<std::size_t>(column) * table.rows + row];
  };
  EXPECT_NEAR(at("true_tx", 7), 0.7, 1e-6);
  EXPECT_NEAR(at("error_m", 7), 0, 1e-6);
  EXPECT_TRUE(std::isnan(at("true_tx", 6)));            // lost
  EXPECT_TRUE(std::isnan(at("median_distance_m", 2)));  // never registered
  EXPECT_EQ(app::true_path(run).size(), 30u);
}

TEST(FrameTable, ThinsLongRuns) {
  app::Reconstruction run = straight_run({});
  run.frames.resize(100'001, run.frames.back());
  run.reads.resize(run.frames.size());
  const app::FrameTable table = app::frame_table(run);
  EXPECT_EQ(table.stride, 3);
  EXPECT_EQ(table.rows, 33'334u);
  EXPECT_EQ(table.values.size(), table.rows * table.columns.size());
}

class ReportFile : public SmallSequence {
 protected:
  /// What the program has put into a page; the rest is the same for all.
  static std::string data_of(const std::string& page) {
    const std::string text = read_text(page);
    const std::size_t begin = text.find("<script type=\"application/json\""), end = text.rfind("<script>");
    return begin < end && end != std::string::npos ? text.substr(begin, end - begin) : "no data";
  }
  void SetUp() override {
    if (!app::can_report()) GTEST_SKIP() << "built without the report";
  }
};

TEST_F(ReportFile, LiesBesideEveryRun) {
  const Outcome outcome = plumbline(small_run(sequence(), output()));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("report     " + output() + "/report.html"));
  EXPECT_THAT(data_of(output() + "/report.html"),
              AllOf(HasSubstr("All 10 frames were tracked"), HasSubstr("id=\"mesh-indices\"")));
  // A later run without one must not leave the page of another.
  EXPECT_EQ(plumbline(small_run(sequence(), output(), {"--no-report"})).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(output() + "/report.html"));
}

TEST_F(ReportFile, WordsOfTheUserAreNoMarkup) {
  std::filesystem::create_directories(path("a<"));
  std::filesystem::create_directories(path("a<") + "/script><b>");
  const std::string folder = path("a<") + "/script><b>";
  ASSERT_EQ(plumbline(small_run(sequence(), folder)).exit_code, 0);
  EXPECT_THAT(data_of(folder + "/report.html"),
              AllOf(HasSubstr("\\u003c/script>\\u003cb>"), Not(HasSubstr("</script><b>"))));
}

TEST_F(ReportFile, AFullDiskCostsThePageAndNothingElse) {
  Launch launch;
  launch.in_child = [] {
    const rlimit limit{650'000, 650'000};  // more than the mesh has, less than the page
    setrlimit(RLIMIT_FSIZE, &limit);
  };
  const Outcome outcome = plumbline(small_run(sequence(), output()), launch);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("warning: there is no report of this run"), HasSubstr("report.html")));
  for (const char* name : {"trajectory.txt", "mesh.ply", "frames.csv", "config.toml", "summary.json"})
    EXPECT_TRUE(std::filesystem::exists(output() + "/" + name)) << name;
  EXPECT_FALSE(std::filesystem::exists(output() + "/report.html"));
  EXPECT_FALSE(std::filesystem::exists(output() + "/report.html.partial"));
}

/// Stands in for the desktop: writes down what it was asked to open.
class View : public ReportFile {
 protected:
  Outcome view(const std::vector<std::string>& more, const std::string& display) {
    std::vector<std::string> arguments = {"view"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    std::filesystem::create_directories(path("bin"));
    write_text(path("bin/xdg-open"), "#!/bin/sh\nprintf %s \"$1\" > \"" + path("opened") + "\"\n");
    chmod(path("bin/xdg-open").c_str(), 0755);
    Launch launch;
    launch.in_child = [this, display] {
      for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY", "BROWSER"}) unsetenv(name);
      if (!display.empty()) setenv("DISPLAY", display.c_str(), 1);
      setenv("PATH", (path("bin") + ":/usr/bin:/bin").c_str(), 1);
      setenv("XDG_CACHE_HOME", path("cache").c_str(), 1);
    };
    return plumbline(arguments, launch);
  }
};

TEST_F(View, OpensTheReportOfARunAndAPageOfAMesh) {
  good_mesh();
  EXPECT_EQ(view({output()}, ":0").exit_code, 0);
  EXPECT_EQ(read_text(path("opened")), output() + "/report.html");
  EXPECT_EQ(view({output() + "/mesh.ply"}, ":0").exit_code, 0);
  EXPECT_EQ(read_text(path("opened")), path("cache/plumbline/view/mesh.html"));
  EXPECT_THAT(read_text(path("opened")), Not(HasSubstr("report.html")));
  std::filesystem::remove(output() + "/report.html");
  EXPECT_EQ(view({output(), "--no-open", "-o", path("page.html")}, "").exit_code, 0);
  EXPECT_THAT(data_of(path("page.html")), AllOf(HasSubstr("mesh.ply"), HasSubstr("id=\"path\"")));
}

TEST_F(View, SaysWhatIsMissing) {
  good_mesh();
  const Outcome blind = view({output()}, "");
  EXPECT_EQ(blind.exit_code, 1);
  EXPECT_THAT(blind.err, AllOf(HasSubstr("report.html: there is no display"), HasSubstr("--no-open")));
  const Outcome empty = view({path("desk")}, ":0");
  EXPECT_EQ(empty.exit_code, 1);
  EXPECT_THAT(empty.err, HasSubstr("neither a report.html nor a mesh.ply"));
  EXPECT_EQ(view({path("none.ply")}, ":0").exit_code, 1);
  EXPECT_EQ(view({}, ":0").exit_code, 2);
}

}  // namespace
}  // namespace plumbline::test
