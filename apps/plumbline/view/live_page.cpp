#include "view/live_page.h"

#ifdef PLUMBLINE_REPORT
// live_page.S
extern "C" const char plumbline_live_page[];
extern "C" const char plumbline_live_page_end[];
#endif

namespace plumbline::app {

std::string_view live_page() {
#ifdef PLUMBLINE_REPORT
  return {plumbline_live_page, static_cast<std::size_t>(plumbline_live_page_end - plumbline_live_page)};
#else
  return {};
#endif
}

}  // namespace plumbline::app
