#include "transfer_options.h"

#include "raysweep/core/error.h"

namespace raysweep::apps {

void addTransferOptions(CLI::App& app, TransferArguments& a, CLI::Option* extinction) {
    auto* const ramp =
        app.add_option("--ramp", a.ramp,
                       "The volume is a solid: opacity of a voxel 0 where its value is LO or less, linear up to ALPHA "
                       "(default: 0.99) where it is HI or more")
            ->type_name("LO,HI[,ALPHA]")
            ->excludes(extinction);
    reads(app.add_option(
              "--transfer", a.table,
              "The same with a table of points {\"value\": v, \"opacity\": a, \"color\": [r,g,b]}; colours, if "
              "there are any, are the albedo"))
        ->type_name("FILE.json")
        ->excludes(extinction)
        ->excludes(ramp);
}

std::optional<Classification> parseRamp(const TransferArguments& a) {
    if (a.ramp.empty()) return std::nullopt;
    const std::vector<double> numbers = parseNumbers(a.ramp, "--ramp", 2, 3, "0.2,1 or --ramp 0.2,1,0.9");
    try {
        return Classification{rampFunction(numbers[0], numbers[1], numbers.size() > 2 ? numbers[2] : kRampOpacity),
                              a.ramp, ""};
    } catch (const InvalidArgument& e) {
        usageError("--ramp", e.what());
    }
}

std::optional<Classification> readTransfer(const TransferArguments& a) {
    if (a.table.empty()) return parseRamp(a);
    try {
        return Classification{readTransferFunction(a.table), "", a.table};
    } catch (const IoError& e) {
        throw about("transfer", e);
    }
}

}  // namespace raysweep::apps
