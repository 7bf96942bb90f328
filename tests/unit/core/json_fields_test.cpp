#include "raysweep/core/json_fields.h"

#include "raysweep/core/error.h"
#include "support/expect_error.h"

#include <gtest/gtest.h>

using namespace raysweep;

namespace {

std::string nested(int depth) {
    return std::string(std::size_t(depth), '[') + std::string(std::size_t(depth), ']');
}

}  // namespace

// What is done with values afterwards recurses, and the stack has an end.
TEST(JsonFields, DeepNestingIsRefused) {
    EXPECT_TRUE(parseJson(nested(64)).is_array());
    test::expectError<IoError>([] { parseJson(nested(70)); }, "nested more than 64 deep");
    test::expectError<IoError>([] { parseJson(nested(300000)); }, "nested more than 64 deep");
    test::expectError<IoError>([] { parseJson(std::string(300000, '[')); }, "nested more than 64 deep");
    std::string objects;
    for (int n = 0; n < 100000; ++n) objects += "{\"a\":";
    test::expectError<IoError>([&] { parseJson(objects); }, "nested more than 64 deep");
}

TEST(JsonFields, KeysOccurOnce) {
    test::expectError<IoError>([] { parseJson(R"({"a": {"b": 1, "b": 2}})"); }, "'b' is given twice");
    EXPECT_EQ(parseJson(R"({"a": {"b": 1}, "b": 2})")["b"], 2);
}
