#include "report/report_template.h"

#ifdef PLUMBLINE_REPORT
// report_page.S
extern "C" const char plumbline_report_page[];
extern "C" const char plumbline_report_page_end[];
#endif

namespace plumbline::app {

std::string_view report_template() {
#ifdef PLUMBLINE_REPORT
  return {plumbline_report_page, static_cast<std::size_t>(plumbline_report_page_end - plumbline_report_page)};
#else
  return {};
#endif
}

}  // namespace plumbline::app
