#include "raysweep/core/error.h"

#include <gtest/gtest.h>

using namespace raysweep;

TEST(Error, SaidOfASubjectKeepsItsRemedyAndThePlaceOfIt) {
    const InvalidArgument error("there are two", Remedy::chooseSeries, ": a, b");
    const InvalidArgument longer = about("head", error);
    EXPECT_STREQ(longer.what(), "head: there are two: a, b");
    EXPECT_EQ(longer.remedy, Remedy::chooseSeries);
    EXPECT_EQ(longer.subject, "head");
    EXPECT_EQ(std::string(longer.what()).substr(longer.remedyAt), ": a, b");
}

TEST(Error, HasNoRemedyUnlessGiven) {
    const IoError error("cannot read");
    EXPECT_EQ(error.remedy, Remedy::none);
    EXPECT_STREQ(about("x", error).what(), "x: cannot read");
}
