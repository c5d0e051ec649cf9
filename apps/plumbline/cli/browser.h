// The desktop's browser.
#pragma once

#include <string>

namespace plumbline::app {

bool has_desktop();

/// Hands a page to the desktop's browser. Throws Error where there is none.
void open_in_browser(const std::string& page);

/// A folder of this user's for pages of this kind: in the cache, or where temporary files go.
std::string page_folder();

/// Opens a URL that others must not see: a command line is seen by all users of a machine, so the browser is given a
/// file that only this user can read and that leads there. It goes with the object.
class BrowserRedirect {
 public:
  /// Throws Error where there is no browser or the file cannot be written.
  explicit BrowserRedirect(const std::string& url);
  ~BrowserRedirect();
  BrowserRedirect(const BrowserRedirect&) = delete;
  BrowserRedirect& operator=(const BrowserRedirect&) = delete;

 private:
  std::string path_;
};

}  // namespace plumbline::app
