#include "view/pages.h"

#include <string_view>

#ifdef PLUMBLINE_REPORT
// pages.S
extern "C" const char plumbline_report_page[];
extern "C" const char plumbline_report_page_end[];
extern "C" const char plumbline_live_page[];
extern "C" const char plumbline_live_page_end[];
extern "C" const char plumbline_page_packages[];
extern "C" const char plumbline_page_packages_end[];
#endif

namespace plumbline::app {

#ifdef PLUMBLINE_REPORT
namespace {

std::string with_packages(std::string_view page) {
  constexpr std::string_view kMark = "/* packages */";
  const std::string_view packages(plumbline_page_packages, plumbline_page_packages_end);
  std::string whole(page);
  return whole.replace(whole.find(kMark), kMark.size(), packages);
}

}  // namespace

bool has_pages() { return true; }
std::string live_page() { return with_packages({plumbline_live_page, plumbline_live_page_end}); }
std::string report_template() { return with_packages({plumbline_report_page, plumbline_report_page_end}); }
#else
bool has_pages() { return false; }
std::string live_page() { return {}; }
std::string report_template() { return {}; }
#endif

}  // namespace plumbline::app
