/// readVdb keeps what it read of a damaged file on purpose: OpenVDB cannot destroy it safely. ITK's readers of NRRD and
/// MetaImage leak their messages and headers where a file is refused.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
    return "leak:readTopology\nleak:readBuffers\nleak:readNext\nleak:libITKNrrdIO\nleak:libITKMetaIO\n";
}
