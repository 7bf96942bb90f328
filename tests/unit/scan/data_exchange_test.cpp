// Scans in HDF5: what is in the file comes out, and files that lack something are refused by the name of what they
// lack.
#include "raysweep/scan/data_exchange.h"

#include "raysweep/core/run_outputs.h"
#include "raysweep/scan/line_integrals.h"

#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "support/temporary_folder.h"
#include "support/volume_files.h"
#include "support/volumes.h"
#include "support/worst.h"
#include "unit/scan/ct_fixture.h"
#include "unit/scan/hdf5_file.h"

using namespace raysweep;
using namespace raysweep::test;

namespace {

class DataExchangeFile : public ::testing::Test {
  protected:
    /// 4 views of 5 columns and 3 rows, 2 flat frames, 3 dark ones; without the dataset `left`.
    void write(const std::string& left = "") {
        Hdf5File file(path);
        if (left != "data") file.addCounts("data", {4, 3, 5}, 1000);
        if (left != "data_white") file.addCounts("data_white", {2, 3, 5}, 3000);
        if (left != "data_dark") file.addCounts("data_dark", {3, 3, 5}, 10);
        if (left != "theta") file.addAngles({0, 45, 90, 135});
    }
    void expectRefused(const std::string& message) {
        testing::internal::CaptureStderr();
        expectError<IoError>([&] { readDataExchange(path); }, message);
        EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "HDF5 prints";
    }

    DataExchange rowsOf(const RowRange& rows) {
        DataExchangeOptions options;
        options.rows = rows;
        return readDataExchange(path, options);
    }

    TemporaryFolder folder;
    const std::string path = folder / "scan.h5";
};

}  // namespace

TEST_F(DataExchangeFile, CountsAnglesAndMeanFramesComeOut) {
    write();
    const DataExchange scan = readDataExchange(path);
    EXPECT_TRUE(scan.complete);
    EXPECT_EQ(scan.counts.width, 5);
    EXPECT_EQ(scan.counts.height, 3);
    EXPECT_EQ(scan.counts.views, 4);
    for (std::size_t p = 0; p < 60; ++p) EXPECT_EQ(scan.counts.values[p], 1000 + float(p));
    ASSERT_EQ(scan.flat.size(), 15u);
    ASSERT_EQ(scan.dark.size(), 15u);
    for (std::size_t p = 0; p < 15; ++p) {
        EXPECT_EQ(scan.flat[p], 3000 + float(p) + 7.5f) << "mean of two frames 15 apart";
        EXPECT_EQ(scan.dark[p], 10 + float(p) + 15) << "mean of three frames 15 apart";
    }
    EXPECT_EQ(scan.flatFrames, 2);
    EXPECT_EQ(scan.darkFrames, 3);
    EXPECT_EQ(scan.angles, (std::vector<double>{0, 45, 90, 135}));
}

TEST_F(DataExchangeFile, ChosenRowsAreThoseOfTheWhole) {
    write();
    const DataExchange all = readDataExchange(path), some = rowsOf(RowRange{1, 2});
    EXPECT_EQ(some.counts.height, 2);
    ASSERT_EQ(some.flat.size(), 10u);
    for (int n = 0; n < 4; ++n)
        for (std::size_t p = 0; p < 10; ++p) EXPECT_EQ(some.counts.view(n)[p], all.counts.view(n)[5 + p]);
    for (std::size_t p = 0; p < 10; ++p) EXPECT_EQ(some.dark[p], all.dark[5 + p]);
    for (const RowRange rows : {RowRange{-1, 1}, RowRange{2, 1}, RowRange{0, 3}})
        expectError<InvalidArgument>([&] { rowsOf(rows); }, "it has rows 0 to 2");
}

TEST_F(DataExchangeFile, AnglesAndDarkFramesMayBeMissing) {
    write("theta");
    EXPECT_TRUE(readDataExchange(path).angles.empty());
    write("data_dark");
    EXPECT_TRUE(readDataExchange(path).dark.empty());
    for (const std::string name : {"data", "data_white"}) {
        write(name);
        expectRefused("there is no dataset /exchange/" + name);
    }
    DataExchangeOptions withoutFlat;
    withoutFlat.flat = false;
    EXPECT_TRUE(readDataExchange(path, withoutFlat).flat.empty()) << "frames come from elsewhere";
}

TEST_F(DataExchangeFile, SinogramOrderIsKnownByTheAttributeOrBySizes) {
    // Counts of view n, row y, column x: 100 n + 10 y + x.
    const auto stored = [&](bool sinograms, hsize_t views, hsize_t rows, hsize_t columns) {
        std::vector<int> counts;
        for (hsize_t a = 0; a < (sinograms ? rows : views); ++a)
            for (hsize_t b = 0; b < (sinograms ? views : rows); ++b)
                for (hsize_t x = 0; x < columns; ++x)
                    counts.push_back(int(100 * (sinograms ? b : a) + 10 * (sinograms ? a : b) + x));
        return counts;
    };
    const auto expectInPlace = [&](const DataExchange& scan) {
        for (int n = 0; n < scan.counts.views; ++n)
            for (int y = 0; y < scan.counts.height; ++y)
                for (int x = 0; x < scan.counts.width; ++x)
                    EXPECT_EQ(scan.counts.view(n)[y * scan.counts.width + x], float(100 * n + 10 * y + x));
        for (std::size_t y = 0; y < std::size_t(scan.counts.height); ++y)
            EXPECT_EQ(scan.flat[y * std::size_t(scan.counts.width)], 50 + 10 * float(y)) << "mean of two frames";
    };
    for (const bool framesToo : {true, false}) {  // frames ordered likewise, or one after the other
        Hdf5File file(path);
        const std::vector<int> data = stored(true, 4, 3, 5), frames = stored(framesToo, 2, 3, 5);
        file.add("data", {3, 4, 5}, H5T_STD_U16LE, H5T_NATIVE_INT, data.data());
        file.add("data_white", framesToo ? std::vector<hsize_t>{3, 2, 5} : std::vector<hsize_t>{2, 3, 5}, H5T_STD_U16LE,
                 H5T_NATIVE_INT, frames.data());
        file.addAngles({0, 45, 90, 135});
        file.close();
        const DataExchange scan = readDataExchange(path);
        EXPECT_TRUE(scan.sinograms);
        ASSERT_EQ(scan.counts.views, 4);
        ASSERT_EQ(scan.counts.height, 3);
        expectInPlace(scan);
        const DataExchange some = rowsOf(RowRange{1, 2});
        EXPECT_EQ(some.counts.view(3)[5], 321.0f - 1) << "view 3, row 2, column 0";
        EXPECT_EQ(some.flat[0], 60);
    }
    {  // as many rows as views: the attribute says it
        Hdf5File file(path);
        const std::vector<int> data = stored(true, 4, 4, 5), frames = stored(false, 2, 4, 5);
        file.add("data", {4, 4, 5}, H5T_STD_U16LE, H5T_NATIVE_INT, data.data());
        file.addText("data", "axes", "y:theta:x");
        file.add("data_white", {2, 4, 5}, H5T_STD_U16LE, H5T_NATIVE_INT, frames.data());
    }
    EXPECT_TRUE(readDataExchange(path).sinograms);
    expectInPlace(readDataExchange(path));
}

TEST_F(DataExchangeFile, OneRowMayLackADimensionAndFlatFramesHaveAnotherName) {
    {
        Hdf5File file(path);
        file.addCounts("data", {4, 5}, 0);
        file.addCounts("data_flat", {2, 5}, 100);
        file.addCounts("data_dark", {1, 5}, 7);
        file.addAngles({0, 1, 2, 3});
        file.addText("theta", "units", "rad");
    }
    const DataExchange scan = readDataExchange(path);
    EXPECT_EQ(scan.counts.views, 4);
    EXPECT_EQ(scan.counts.height, 1);
    EXPECT_EQ(scan.counts.view(2)[3], 13.0f);
    EXPECT_EQ(scan.flat, (std::vector<float>{102.5f, 103.5f, 104.5f, 105.5f, 106.5f}));
    EXPECT_EQ(scan.flatFrames, 2);
    EXPECT_EQ(scan.dark[0], 7.0f);
    EXPECT_EQ(scan.angleUnits, "rad");
}

TEST_F(DataExchangeFile, FramesThatAreBrokenInPartsAreMeantWithoutThem) {
    {
        Hdf5File file(path);
        file.addCounts("data", {4, 1, 3}, 0);
        const std::vector<float> frames = {10, std::nanf(""), INFINITY, 20, 30, std::nanf("")};
        file.add("data_white", {2, 1, 3}, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, frames.data());
    }
    const DataExchange scan = readDataExchange(path);
    EXPECT_EQ(scan.flat[0], 15.0f);
    EXPECT_EQ(scan.flat[1], 30.0f);
    EXPECT_TRUE(std::isnan(scan.flat[2]));
}

TEST_F(DataExchangeFile, CountsOfAWrongNumberTypeAreRefusedOrAsMeant) {
    const auto writeAs = [&](const char* wrapped) {
        const std::vector<int> counts = {100, 40100, 200, 30000, 500, 65000}, dark(3, 100);
        Hdf5File file(path);
        std::vector<std::int16_t> low(counts.begin(), counts.end());  // 40100 becomes -25436
        for (const std::string name : {"data", "data_white"})
            if (name == wrapped)
                file.add(name, {2, 1, 3}, H5T_STD_I16LE, H5T_NATIVE_INT16, low.data());
            else
                file.add(name, {2, 1, 3}, H5T_STD_U16LE, H5T_NATIVE_INT, counts.data());
    };
    for (const std::string name : {"data", "data_white"}) {
        writeAs(name.c_str());
        expectError<InvalidArgument>([&] { readDataExchange(path); },
                                     "/exchange/" + name + ": counts are as low as -25436");
        DataExchangeOptions meant;
        meant.unsignedCounts = true;
        EXPECT_EQ(readDataExchange(path, meant).counts.view(0)[1], 40100.0f);
        EXPECT_EQ(readDataExchange(path, meant).flat[2], 0.5f * (200 + 65000));
    }
}

TEST_F(DataExchangeFile, NumbersOfOddBitsAreRefusedBeforeTheyAreRead) {
    const auto writeAs = [&](hid_t type) {
        Hdf5File file(path);
        std::vector<std::int64_t> bytes(64);
        file.add("data", {2, 2, 2}, type, type, bytes.data());
        file.addCounts("data_white", {2, 2, 2}, 0);
    };
    const hid_t odd = H5Tcopy(H5T_STD_I32LE), shifted = H5Tcopy(H5T_STD_U16LE), half = H5Tcopy(H5T_IEEE_F32LE);
    H5Tset_size(odd, 3);
    H5Tset_precision(shifted, 12);
    H5Tset_fields(half, 15, 10, 5, 0, 10);
    H5Tset_size(half, 2);
    H5Tset_ebias(half, 15);
    for (const hid_t type : {odd, shifted}) {
        writeAs(type);
        expectRefused("/exchange/data: its numbers are of a type that is not known");
    }
    writeAs(half);
    EXPECT_EQ(readDataExchange(path).counts.values[0], 0.0f);
    for (const hid_t type : {odd, shifted, half}) H5Tclose(type);
}

TEST_F(DataExchangeFile, ValuesInOtherFilesMustBeThere) {
    const std::string part = folder / "part.h5";
    const auto writeVirtual = [&](hsize_t mapped) {
        const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
        const hid_t group = H5Gcreate2(file, "exchange", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
        const hsize_t sizes[] = {4, 3, 5}, some[] = {mapped, 3, 5}, start[] = {0, 0, 0};
        const hid_t space = H5Screate_simple(3, sizes, nullptr), source = H5Screate_simple(3, sizes, nullptr);
        H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, some, nullptr);
        H5Sselect_hyperslab(source, H5S_SELECT_SET, start, nullptr, some, nullptr);
        for (const char* name : {"data", "data_white"}) {
            const hid_t how = H5Pcreate(H5P_DATASET_CREATE);
            H5Pset_virtual(how, space, "part.h5", "exchange/data", source);
            H5Dclose(H5Dcreate2(group, name, H5T_STD_U16LE, space, H5P_DEFAULT, how, H5P_DEFAULT));
            H5Pclose(how);
        }
        H5Sclose(source);
        H5Sclose(space);
        H5Gclose(group);
        H5Fclose(file);
    };
    Hdf5File(part).addCounts("data", {4, 3, 5}, 1000);
    writeVirtual(4);
    EXPECT_EQ(readDataExchange(path).counts.values[59], 1059.0f);
    writeVirtual(3);
    expectRefused("which leave parts of it empty");
    writeVirtual(4);
    std::filesystem::remove(part);
    expectRefused("/exchange/data: it is put together of others, and 'exchange/data' in '" + part);
}

namespace {

/// A file whose counts, 4 views of 3 x 5, and flat frames are in others. @param how makes a dataset so
void writeElsewhere(const std::string& path, const std::function<void(hid_t creation)>& how, bool grows = false) {
    const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t group = H5Gcreate2(file, "exchange", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const hsize_t sizes[] = {4, 3, 5}, most[] = {grows ? H5S_UNLIMITED : 4, 3, 5};
    const hid_t space = H5Screate_simple(3, sizes, most);
    for (const char* name : {"data", "data_white"}) {
        const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
        how(creation);
        H5Dclose(H5Dcreate2(group, name, H5T_STD_U16BE, space, H5P_DEFAULT, creation, H5P_DEFAULT));
        H5Pclose(creation);
    }
    H5Sclose(space);
    H5Gclose(group);
    H5Fclose(file);
}

/// From one file.
void virtualOf(hid_t creation, const char* file, const char* set) {
    const hsize_t sizes[] = {4, 3, 5};
    const hid_t space = H5Screate_simple(3, sizes, nullptr);
    EXPECT_GE(H5Pset_virtual(creation, space, file, set, space), 0);
    H5Sclose(space);
}

/// `each` views from each file of a series, `every` views from each other.
void seriesOf(hid_t creation, hsize_t each, hsize_t every) {
    const hsize_t sizes[] = {4, 3, 5}, most[] = {H5S_UNLIMITED, 3, 5}, part[] = {each, 3, 5};
    const hsize_t start[] = {0, 0, 0}, stride[] = {every, 3, 5}, count[] = {H5S_UNLIMITED, 1, 1};
    const hid_t space = H5Screate_simple(3, sizes, most), source = H5Screate_simple(3, part, nullptr);
    H5Sselect_hyperslab(space, H5S_SELECT_SET, start, stride, count, part);
    EXPECT_GE(H5Pset_virtual(creation, space, "part%b.h5", "exchange/data", source), 0);
    H5Sclose(source);
    H5Sclose(space);
}

}  // namespace

TEST_F(DataExchangeFile, FilesThatValuesAreInAreInputs) {
    const std::string part = folder / "part.h5", raw = folder / "raw.bin";
    const auto expectInputs = [&](const std::vector<std::string>& inputs) {
        RunOutputs outputs;
        EXPECT_EQ(readDataExchange(path).counts.values[59], 1059.0f);
        for (const std::string& input : inputs) EXPECT_THROW(requireNotRead(input), IoError) << input;
    };
    Hdf5File(part).addCounts("data", {4, 3, 5}, 1000);
    writeElsewhere(path, [](hid_t creation) { virtualOf(creation, "part.h5", "exchange/data"); });
    expectInputs({part});
    // And what those are made of.
    const std::string between = folder / "between.h5";
    writeElsewhere(between, [](hid_t creation) { virtualOf(creation, "part.h5", "exchange/data"); });
    writeElsewhere(path, [](hid_t creation) { virtualOf(creation, "between.h5", "exchange/data"); });
    expectInputs({part, between});

    std::ofstream bytes(raw, std::ios::binary);
    for (int i = 0; i < 60; ++i) bytes << char((1000 + i) >> 8) << char((1000 + i) & 255);
    bytes.close();
    writeElsewhere(path, [&](hid_t creation) { H5Pset_external(creation, raw.c_str(), 0, 120); });
    expectInputs({raw});
}

// A pipe would be waited for.
TEST_F(DataExchangeFile, ValuesInWhatIsNoRegularFileAreRefused) {
    const std::string pipe = folder / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    writeElsewhere(path, [&](hid_t creation) { H5Pset_external(creation, pipe.c_str(), 0, 120); });
    expectRefused("its values are in '" + pipe + "': it is a device or a pipe");
    writeElsewhere(path, [](hid_t creation) { virtualOf(creation, "pipe", "exchange/data"); });
    expectRefused("its values are in '" + pipe + "': it is a device or a pipe");
    writeElsewhere(
        path, [](hid_t creation) { seriesOf(creation, 2, 2); }, true);
    std::filesystem::rename(pipe, folder / "part0.h5");
    expectRefused("part0.h5': it is a device or a pipe");
}

TEST_F(DataExchangeFile, ASeriesOfFilesIsCheckedAsASingleOneIs) {
    const std::string first = folder / "part0.h5", second = folder / "part1.h5";
    Hdf5File(first).addCounts("data", {2, 3, 5}, 1000);
    Hdf5File(second).addCounts("data", {2, 3, 5}, 1030);
    writeElsewhere(
        path, [](hid_t creation) { seriesOf(creation, 2, 2); }, true);
    {
        RunOutputs outputs;
        const DataExchange scan = readDataExchange(path);
        EXPECT_EQ(scan.counts.views, 4);
        EXPECT_EQ(scan.counts.values[59], 1059.0f);
        EXPECT_THROW(requireNotRead(first), IoError);
        EXPECT_THROW(requireNotRead(second), IoError);
    }
    // One view of three is in no file.
    Hdf5File(first).addCounts("data", {2, 3, 5}, 1000);
    writeElsewhere(
        path, [](hid_t creation) { seriesOf(creation, 2, 3); }, true);
    expectRefused("which leave parts of it empty");
}

TEST_F(DataExchangeFile, SizesThatDoNotFitAreRefusedByDataset) {
    {
        Hdf5File file(path);
        file.addCounts("data", {4, 3, 5}, 0);
        file.addCounts("data_white", {2, 3, 4}, 0);
        file.addCounts("data_dark", {2, 3, 5}, 0);
    }
    expectRefused("/exchange/data_white: its size is 2 x 3 x 4, which does not fit that of /exchange/data, 4 x 3 x 5");
    {
        Hdf5File file(path);
        file.addCounts("data", {12, 5}, 0);
        file.addCounts("data_white", {2, 3, 5}, 0);
        file.addCounts("data_dark", {2, 3, 5}, 0);
    }
    expectRefused("/exchange/data_white: its size is 2 x 3 x 5, which does not fit that of /exchange/data, 12 x 5");
    {
        Hdf5File file(path);
        file.addCounts("data", {12}, 0);
        file.addCounts("data_white", {2, 3, 5}, 0);
    }
    expectRefused("/exchange/data: its size is 12, but it must be views x rows x columns");
    write("theta");
    {
        Hdf5File file(path);
        file.addCounts("data", {4, 3, 5}, 0);
        file.addCounts("data_white", {2, 3, 5}, 0);
        file.addCounts("data_dark", {2, 3, 5}, 0);
        file.addAngles({0, 60, 120});
    }
    expectRefused("/exchange/theta: it has 3 angles, but /exchange/data has 4 views");
}

TEST_F(DataExchangeFile, TextInsteadOfNumbersIsRefused) {
    {
        Hdf5File file(path);
        const hid_t text = H5Tcopy(H5T_C_S1);
        H5Tset_size(text, 4);
        file.add("data", {1, 1, 1}, text, text, "abc");
        H5Tclose(text);
        file.addCounts("data_white", {1, 1, 1}, 0);
        file.addCounts("data_dark", {1, 1, 1}, 0);
    }
    expectRefused("/exchange/data: it must hold numbers");
}

TEST_F(DataExchangeFile, TruncatedAndForeignFilesAreRefusedInSilence) {
    write();
    const auto whole = std::filesystem::file_size(path);
    for (const double part : {0.9, 0.5, 0.1}) {
        std::filesystem::resize_file(path, std::uintmax_t(double(whole) * part));
        expectRefused("it is no HDF5 file, or damaged (");
    }
    writeFile(path, "not HDF5");
    expectRefused("it is no HDF5 file, or damaged (");
    std::filesystem::remove(path);
    expectRefused("there is no such file");
    H5Fclose(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
    expectRefused("it has no group /exchange");
}

TEST_F(DataExchangeFile, DamagedPackedDataAreRefusedByDataset) {
    {
        const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
        const hid_t group = H5Gcreate2(file, "exchange", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
        const hsize_t sizes[] = {4, 8, 64};
        const hid_t space = H5Screate_simple(3, sizes, nullptr), how = H5Pcreate(H5P_DATASET_CREATE);
        H5Pset_chunk(how, 3, sizes);
        H5Pset_fletcher32(how);
        std::vector<float> counts(4 * 8 * 64, 12345.0f);
        for (const char* name : {"data", "data_white", "data_dark"}) {
            const hid_t set = H5Dcreate2(group, name, H5T_IEEE_F32LE, space, H5P_DEFAULT, how, H5P_DEFAULT);
            H5Dwrite(set, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, counts.data());
            H5Dclose(set);
            counts.assign(counts.size(), 1.0f);
        }
        H5Pclose(how);
        H5Sclose(space);
        H5Gclose(group);
        H5Fclose(file);
    }
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(file)), {});
    const float count = 12345.0f;
    const std::size_t at = bytes.find(std::string(reinterpret_cast<const char*>(&count), 4) +
                                      std::string(reinterpret_cast<const char*>(&count), 4));
    ASSERT_NE(at, std::string::npos);
    file.seekp(std::streamoff(at + 400));
    file.put('x');
    file.close();
    expectRefused("/exchange/data: it is damaged");
}

TEST_F(DataExchangeFile, ViewsThatWereNeverWrittenAreNotTakenForZeros) {
    const auto writeViews = [&](hsize_t written) {
        const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
        const hid_t group = H5Gcreate2(file, "exchange", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
        const hsize_t sizes[] = {4, 2, 8}, one[] = {1, 2, 8};
        const hid_t space = H5Screate_simple(3, sizes, nullptr), view = H5Screate_simple(3, one, nullptr);
        const hid_t how = H5Pcreate(H5P_DATASET_CREATE);
        H5Pset_chunk(how, 3, one);
        H5Pset_deflate(how, 1);
        const std::vector<float> counts(4 * 2 * 8, 7.0f);
        for (const std::string name : {"data", "data_white", "data_dark"}) {
            const hid_t set = H5Dcreate2(group, name.c_str(), H5T_IEEE_F32LE, space, H5P_DEFAULT, how, H5P_DEFAULT);
            for (hsize_t n = 0; n < (name == "data" ? written : 4); ++n) {
                const hsize_t start[] = {n, 0, 0};
                H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, one, nullptr);
                H5Dwrite(set, H5T_NATIVE_FLOAT, view, space, H5P_DEFAULT, counts.data());
            }
            H5Dclose(set);
        }
        H5Pclose(how);
        H5Sclose(view);
        H5Sclose(space);
        H5Gclose(group);
        H5Fclose(file);
    };
    writeViews(4);
    EXPECT_EQ(readDataExchange(path).counts.view(3)[15], 7.0f);
    for (const hsize_t written : {0, 3}) {
        writeViews(written);
        expectRefused("/exchange/data: parts of it were never written");
    }
}

TEST_F(DataExchangeFile, StoppedReadingSaysSo) {
    write();
    EXPECT_FALSE(readDataExchange(path, {}, [](const std::string&, double) { return false; }).complete);
}

TEST(DataExchange, ToothScanGivesLineIntegrals) {
    const std::string path = findData("ct/tomopy_tooth.h5");
    if (path.empty()) GTEST_SKIP() << "ct/tomopy_tooth.h5 is not on this machine; set RAYSWEEP_DATA";
    const DataExchange scan = readDataExchange(path);
    ASSERT_EQ(scan.counts.width, 640);
    ASSERT_EQ(scan.counts.height, 2);
    ASSERT_EQ(scan.counts.views, 181);
    EXPECT_EQ(scan.flatFrames, 10);
    EXPECT_EQ(scan.darkFrames, 10);
    ASSERT_EQ(scan.angles.size(), 181u);
    EXPECT_NEAR(scan.angles[180], 180.0 * 180 / 181, 1e-3);  // one step before half a turn
    const LineIntegrals tooth = lineIntegrals(scan.counts, scan.flat, scan.dark);
    EXPECT_EQ(tooth.deadPixels, 0u);

    // The same scan, made into line integrals by TomoPy.
    const std::string reference = findData("ct/tooth_2slices.raw");
    if (reference.empty()) GTEST_SKIP() << "ct/tooth_2slices.raw is not on this machine; set RAYSWEEP_DATA";
    std::vector<float> expected(tooth.projections.values.size());
    std::ifstream(reference, std::ios::binary)
        .read(reinterpret_cast<char*>(expected.data()), std::streamsize(4 * expected.size()));
    double worst = 0;
    for (std::size_t p = 0; p < expected.size(); ++p)
        raiseTo(worst, std::abs(double(expected[p]) - tooth.projections.values[p]));
    EXPECT_LE(worst, 1.3e-7);  // found 1.2e-7: the last bit of a float above 1
}
