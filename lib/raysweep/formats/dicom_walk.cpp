// Source: DICOM PS3.5, 7 (the data set), A (transfer syntaxes).
#include "raysweep/formats/dicom_walk.h"

#include "raysweep/formats/header_lines.h"
#include "raysweep/formats/read_failure.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <set>

namespace raysweep {
namespace {

constexpr std::uint32_t kUndefined = 0xffffffff, kItem = 0xfffee000, kItemEnd = 0xfffee00d, kSequenceEnd = 0xfffee0dd;
constexpr std::uint32_t kPixels = 0x7fe00010;
constexpr std::uint64_t kNowhere = std::uint64_t(-1);

struct Coding {
    bool isExplicit = true, bigEndian = false;
};

struct Element {
    std::uint32_t tag = 0, length = 0;
    bool sequence = false, unknown = false;
};

class Walk {
  public:
    explicit Walk(const std::string& file) : file_(file), size_(sizeOfFile(file)), in_(file, std::ios::binary) {}

    DicomStructure go() {
        const Coding coding = findCoding();
        while (at_ < size_ && !(structure_.pixels && zerosFollow())) take(next(coding), coding, 0);
        structure_.end = at_;
        structure_.trailing = at_ < size_;
        return structure_;
    }

  private:
    [[noreturn]] void fail(const std::string& why) const {
        failRead(file_,
                 "it is not DICOM, is malformed, or ends early (" + why + " at byte " + std::to_string(at_) + ")");
    }

    template <class Number>
    Number read(bool bigEndian) {
        std::byte raw[sizeof(Number)];
        if (!in_.read(reinterpret_cast<char*>(raw), sizeof raw)) fail("it ends in an element");
        at_ += sizeof raw;
        if (bigEndian) std::reverse(raw, raw + sizeof raw);
        Number number;
        std::memcpy(&number, raw, sizeof raw);
        return number;
    }

    std::uint32_t readTag(bool bigEndian) {
        const auto group = read<std::uint16_t>(bigEndian);
        return std::uint32_t(group) << 16 | read<std::uint16_t>(bigEndian);
    }

    /// Where a group should be, which is 0 in no data set.
    bool zerosFollow() {
        char group[2] = {};
        in_.read(group, std::min<std::streamsize>(sizeof group, std::streamsize(size_ - at_)));
        in_.seekg(std::streamoff(at_));
        return group[0] == 0 && group[1] == 0;
    }

    void skip(std::uint64_t bytes) {
        if (bytes > size_ - at_) fail("an element is longer than the file");
        at_ += bytes;
        in_.seekg(std::streamoff(at_));
    }

    Element next(const Coding& coding) {
        static const std::set<std::string> kLong = {"OB", "OD", "OF", "OL", "OV", "OW", "SQ",
                                                    "SV", "UC", "UN", "UR", "UT", "UV"};
        static const std::set<std::string> kShort = {"AE", "AS", "AT", "CS", "DA", "DS", "DT", "FD", "FL", "IS", "LO",
                                                     "LT", "PN", "SH", "SL", "SS", "ST", "TM", "UI", "UL", "US"};
        constexpr int kMostElements = 1 << 20;
        if (++elements_ > kMostElements) fail("there are more elements than in any file");
        Element element;
        element.tag = readTag(coding.bigEndian);
        if (element.tag >> 16 == 0) return element;  // no data set has those: zeros, maybe
        const bool delimits = element.tag >> 16 == 0xfffe;
        if (!coding.isExplicit || delimits) {
            element.length = read<std::uint32_t>(coding.bigEndian);
            return element;
        }
        char kind[2];
        if (!in_.read(kind, 2)) fail("it ends in an element");
        at_ += 2;
        const std::string vr(kind, 2);
        element.sequence = vr == "SQ";
        element.unknown = vr == "UN";
        if (kLong.count(vr) == 0) {
            if (kShort.count(vr) == 0) fail("a value representation is none of DICOM's");  // GDCM may end the program
            element.length = read<std::uint16_t>(coding.bigEndian);
            return element;
        }
        read<std::uint16_t>(coding.bigEndian);
        element.length = read<std::uint32_t>(coding.bigEndian);
        return element;
    }

    /// The rest of an element of a data set.
    void take(const Element& element, const Coding& coding, int depth) {
        constexpr int kDeepest = 32;
        if (depth > kDeepest) fail("sequences are nested too deeply");
        if (element.tag >> 16 == 0 || element.tag >> 16 == 0xfffe) fail("there is an element that no data set has");
        if (element.tag == kPixels && depth == 0) {
            structure_.pixels = true;
            structure_.packed = element.length == kUndefined;
            structure_.pixelBytes = structure_.packed ? 0 : element.length;
        }
        if (element.length != kUndefined && element.sequence && element.length > size_ - at_)
            fail("a sequence is longer than the file");
        if (element.length != kUndefined && element.sequence) return passItems(coding, depth, at_ + element.length);
        if (element.length != kUndefined) return skip(element.length);
        if (element.tag == kPixels) {
            const std::uint64_t fragments = passFragments(coding);
            if (depth == 0) structure_.fragments = fragments;
            return;
        }
        Coding inner = coding;
        if (element.unknown) inner = Coding{false, false};
        passItems(inner, depth, kNowhere);
    }

    /// @return how many there are; the first item is no fragment, but the table of their places, which may be empty
    std::uint64_t passFragments(const Coding& coding) {
        std::uint64_t items = 0;
        for (Element item = next(coding); item.tag != kSequenceEnd; item = next(coding)) {
            if (item.tag != kItem || item.length == kUndefined) fail("a fragment of pixels is malformed");
            skip(item.length);
            ++items;
        }
        return items > 0 ? items - 1 : 0;
    }

    /// Items up to the end of the sequence, which is known or marked.
    void passItems(const Coding& coding, int depth, std::uint64_t end) {
        while (at_ < end) {
            const Element item = next(coding);
            if (item.tag == kSequenceEnd) return;
            if (item.tag != kItem) fail("an item of a sequence is malformed");
            const std::uint64_t itemEnd = item.length == kUndefined ? kNowhere : at_ + item.length;
            while (at_ < itemEnd) {
                const Element element = next(coding);
                if (element.tag == kItemEnd) break;
                take(element, coding, depth + 1);
            }
        }
    }

    /// Past the preamble and the elements of group 2, which are explicit and little endian.
    Coding findCoding() {
        char start[132] = {};
        in_.read(start, sizeof start);
        in_.clear();
        if (size_ < sizeof start || std::memcmp(start + 128, "DICM", 4) != 0) {
            in_.seekg(0);
            if (start[0] != 8 || start[1] != 0 || start[3] != 0) fail("it lacks DICOM's mark");
            return {start[4] >= 'A' && start[4] <= 'Z' && start[5] >= 'A' && start[5] <= 'Z', false};
        }
        at_ = sizeof start;
        std::string syntax = "1.2.840.10008.1.2";
        const Coding meta;
        for (char peeked[2]; in_.read(peeked, 2);) {
            in_.seekg(std::streamoff(at_));
            if (peeked[0] != 2 || peeked[1] != 0) break;
            const Element element = next(meta);
            constexpr std::uint32_t kLongest = 1 << 16;
            if (element.length > kLongest) fail("its meta information is malformed");
            std::string value(element.length, '\0');
            if (!in_.read(value.data(), std::streamsize(value.size()))) fail("it ends in its meta information");
            at_ += element.length;
            constexpr std::uint32_t kTransferSyntax = 0x00020010;
            if (element.tag == kTransferSyntax) syntax = value.substr(0, value.find_first_of(std::string("\0 ", 2)));
        }
        in_.clear();
        in_.seekg(std::streamoff(at_));
        if (syntax == "1.2.840.10008.1.2.1.99")
            failRead(file_, "it is deflated as a whole, which cannot be read; save it in another transfer syntax");
        return {syntax != "1.2.840.10008.1.2", syntax == "1.2.840.10008.1.2.2"};
    }

    std::string file_;
    std::uint64_t size_, at_ = 0;
    std::ifstream in_;
    int elements_ = 0;
    DicomStructure structure_;
};

}  // namespace

DicomStructure walkDicom(const std::string& file) {
    return Walk(file).go();
}

}  // namespace raysweep
