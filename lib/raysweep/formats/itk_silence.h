/// For the files that use ITK and GDCM. Nothing else includes it.
#pragma once

#include <iostream>
#include <sstream>

namespace raysweep {

/// While it lives, what ITK and GDCM would print goes nowhere: a library does not print.
class Silence {
  public:
    Silence();
    ~Silence();
    Silence(const Silence&) = delete;
    Silence& operator=(const Silence&) = delete;

  private:
    std::ostringstream kept_;
    std::streambuf *cerr_, *cout_;
};

}  // namespace raysweep
