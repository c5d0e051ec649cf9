// The one exception of the library: what went wrong, where, and what the user can do.
#pragma once

#include <stdexcept>
#include <string>

#include "plumbline/export.h"

namespace plumbline {

/// Bad input, bad configuration, a device or a file that cannot be used. Losing track is *not* an error but a status.
class PLUMBLINE_EXPORT Error : public std::runtime_error {
 public:
  /// `what` is a sentence without a full stop; `where` a file, option or key; `advice` what to do, in the imperative.
  Error(const std::string& what, const std::string& where, const std::string& advice)
      : std::runtime_error(where + ": " + what + (advice.empty() ? "" : "\n  " + advice)), where_(where) {}

  const std::string& where() const { return where_; }

 private:
  std::string where_;
};

}  // namespace plumbline
