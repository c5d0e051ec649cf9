// What an Error says.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "plumbline/error.h"

namespace plumbline::test {

/// The text of the Error that `call` throws, or a failure and "".
template <class Call>
std::string error_of(Call&& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

}  // namespace plumbline::test
