// What a page may ask for, and what it may not.
#include "view/request.h"

#include <gtest/gtest.h>

#include <string>

namespace plumbline::app {
namespace {

TEST(Request, ReadsEachKind) {
  EXPECT_EQ(parse_request(R"({"do":"start"})")->kind, RequestKind::start);
  EXPECT_EQ(parse_request(R"({"do":"pause"})")->kind, RequestKind::pause);
  EXPECT_EQ(parse_request(R"({"do":"resume"})")->kind, RequestKind::resume);
  EXPECT_EQ(parse_request(R"({"do":"reset"})")->kind, RequestKind::reset);
  EXPECT_EQ(parse_request(R"({"do":"finish"})")->kind, RequestKind::finish);
  EXPECT_EQ(parse_request(R"({"do":"shown","number":12})")->number, 12U);
  EXPECT_EQ(parse_request(R"({"do":"undo","seconds":2.5})")->seconds, 2.5);
  EXPECT_FALSE(parse_request(R"({"do":"crop"})")->box) << "all is kept";
}

TEST(Request, ReadsABox) {
  const auto request = parse_request(R"({"do":"crop","box":{"middle":[1,2,3],"turn":[0,0,0.6,0.8],"size":[2,4,6]}})");
  ASSERT_TRUE(request && request->box);
  EXPECT_EQ(request->box->half, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(request->box->world_from_box.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(request->box->contains({1, 2, 5.9}));
  EXPECT_FALSE(request->box->contains({1, 2, 6.1}));
}

TEST(Request, RefusesEverythingElse) {
  for (const std::string text : {"",
                                 "{",
                                 "[]",
                                 "null",
                                 "\"start\"",
                                 R"({"do":"begin"})",
                                 R"({"do":1})",
                                 R"({"start":true})",
                                 R"({"do":"start","now":true})",
                                 R"({"do":"undo"})",
                                 R"({"do":"undo","seconds":0})",
                                 R"({"do":"undo","seconds":-1})",
                                 R"({"do":"undo","seconds":1e9})",
                                 R"({"do":"undo","seconds":"1"})",
                                 R"({"do":"shown"})",
                                 R"({"do":"shown","number":-1})",
                                 R"({"do":"shown","number":1.5})",
                                 R"({"do":"crop","box":null})",
                                 R"({"do":"crop","box":{"middle":[0,0],"turn":[0,0,0,1],"size":[1,1,1]}})",
                                 R"({"do":"crop","box":{"middle":[0,0,0],"turn":[0,0,0,2],"size":[1,1,1]}})",
                                 R"({"do":"crop","box":{"middle":[0,0,0],"turn":[0,0,0,1],"size":[1,0,1]}})",
                                 R"({"do":"crop","box":{"middle":[0,0,1e300],"turn":[0,0,0,1],"size":[1,1,1]}})",
                                 R"({"do":"crop","box":{"middle":[0,0,0],"turn":[0,0,0,1],"size":[1,1,1],"color":1}})",
                                 "{\"do\":\"start\"}x",
                                 "\xff\xfe"})
    EXPECT_FALSE(parse_request(text)) << text;
  EXPECT_FALSE(parse_request(R"({"do":"start")" + std::string(kMaxRequestBytes, ' ') + "}")) << "too long";
  EXPECT_FALSE(parse_request(std::string(kMaxRequestBytes, '['))) << "deep";
}

}  // namespace
}  // namespace plumbline::app
