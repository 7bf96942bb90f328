# The ```cpp blocks of a Markdown file as one program, which does what they say one after the other.
/^```/ {
    if (inside) inside = 0
    else if ($0 == "```cpp") { inside = 1; ++blocks }
    next
}
inside && /^#include/ { includes = includes $0 "\n"; next }
inside { body[blocks] = body[blocks] "    " $0 "\n" }
END {
    if (!blocks) { print "no C++ found" > "/dev/stderr"; exit 1 }
    print includes
    for (b = 1; b <= blocks; ++b) print "static void block" b "() {\n" body[b] "}\n"
    print "int main() {"
    for (b = 1; b <= blocks; ++b) print "    block" b "();"
    print "}"
}
