// By which names a server may be called.
#include "view/page_server.h"

#include <gtest/gtest.h>

#include "plumbline/error.h"

namespace plumbline::app {
namespace {

TEST(PageServer, AnswersToItsOwnNamesAlone) {
  EXPECT_TRUE(is_own_host("127.0.0.1:8080", 8080, "127.0.0.1"));
  EXPECT_TRUE(is_own_host("localhost:8080", 8080, "127.0.0.1"));
  EXPECT_TRUE(is_own_host("[::1]:8080", 8080, "::1"));
  EXPECT_TRUE(is_own_host("192.168.1.20:8080", 8080, "0.0.0.0"));
  EXPECT_FALSE(is_own_host("127.0.0.1:8081", 8080, "127.0.0.1")) << "another port";
  EXPECT_FALSE(is_own_host("127.0.0.1", 8080, "127.0.0.1")) << "no port";
  EXPECT_FALSE(is_own_host("example.org:8080", 8080, "127.0.0.1")) << "a name that was made to point here";
  EXPECT_FALSE(is_own_host("127.0.0.1.example.org:8080", 8080, "127.0.0.1"));
  EXPECT_FALSE(is_own_host("", 8080, "127.0.0.1"));
}

TEST(PageServer, SaysThatItCannotListen) {
  Board first_board, second_board;
  const PageServer first({}, &first_board, [](const Request&) {});
  const std::string url = first.url();
  const int port = std::stoi(url.substr(url.find(':', 7) + 1));
  EXPECT_THROW(PageServer({port, "127.0.0.1"}, &second_board, [](const Request&) {}), Error);
  EXPECT_THROW(PageServer({0, "not an address"}, &second_board, [](const Request&) {}), Error);
}

TEST(PageServer, GivesEachRunAnotherToken) {
  Board first_board, second_board;
  const PageServer first({}, &first_board, [](const Request&) {}), second({}, &second_board, [](const Request&) {});
  const auto token = [](const std::string& url) { return url.substr(url.find("token=") + 6); };
  EXPECT_EQ(token(first.url()).size(), 32U);
  EXPECT_NE(token(first.url()), token(second.url()));
}

}  // namespace
}  // namespace plumbline::app
