// Scans in HDF5: what is in the file comes out, and files that lack something are refused by the name of what they
// lack.
#include "raysweep/scan/data_exchange.h"

#include "raysweep/scan/line_integrals.h"

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
    const DataExchange all = readDataExchange(path), some = readDataExchange(path, RowRange{1, 2});
    EXPECT_EQ(some.counts.height, 2);
    ASSERT_EQ(some.flat.size(), 10u);
    for (int n = 0; n < 4; ++n)
        for (std::size_t p = 0; p < 10; ++p) EXPECT_EQ(some.counts.view(n)[p], all.counts.view(n)[5 + p]);
    for (std::size_t p = 0; p < 10; ++p) EXPECT_EQ(some.dark[p], all.dark[5 + p]);
    for (const RowRange rows : {RowRange{-1, 1}, RowRange{2, 1}, RowRange{0, 3}})
        expectError<InvalidArgument>([&] { readDataExchange(path, rows); }, "it has rows 0 to 2");
}

TEST_F(DataExchangeFile, AnglesMayBeMissingButNothingElse) {
    write("theta");
    EXPECT_TRUE(readDataExchange(path).angles.empty());
    for (const std::string name : {"data", "data_white", "data_dark"}) {
        write(name);
        expectRefused("there is no dataset /exchange/" + name);
    }
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
    expectRefused("/exchange/data: its size is 12 x 5, but it must be views x rows x columns");
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
