#pragma once

#include <gtest/gtest.h>

#include <exception>
#include <string>

namespace raysweep::test {

/// That `call` ends in an error of this kind whose message has `part`.
template <class Kind, class Call>
void expectError(const Call& call, const std::string& part) {
    try {
        call();
        ADD_FAILURE() << "no error; expected one that says: " << part;
    } catch (const Kind& error) {
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what() << "\n  lacks: " << part;
    } catch (const std::exception& error) {
        ADD_FAILURE() << "an error of another kind: " << error.what();
    }
}

/// What validate() of some options says, "no error" if nothing.
template <class Options>
std::string errorOf(const Options& options) {
    try {
        options.validate();
    } catch (const std::exception& error) {
        return error.what();
    }
    return "no error";
}

}  // namespace raysweep::test
