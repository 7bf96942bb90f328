/// Leaks that are not ours to mend. readVdb keeps what it read of a damaged file on purpose: OpenVDB cannot destroy it
/// safely. OpenImageIO leaks a string when libpng jumps out of a truncated file.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
    return "leak:readTopology\nleak:readBuffers\nleak:readNext\nleak:libOpenImageIO\n";
}

/// Whole call stacks, through libraries without frame pointers too: the names above are found in them.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() {
    return "fast_unwind_on_malloc=0";
}
