#include "raysweep/core/json_fields.h"

#include "raysweep/core/error.h"

#include <limits>
#include <utility>
#include <vector>

namespace raysweep {

using nlohmann::json;

namespace {

/// The library's message without its own name and number of the error.
std::string withoutPrefix(const std::string& message) {
    const std::size_t end = message.find("] ");
    return end == std::string::npos ? message : message.substr(end + 2);
}

}  // namespace

json parseJson(const std::string& text) {
    std::vector<std::set<std::string>> open;
    const auto once = [&open](int depth, json::parse_event_t event, json& value) {
        constexpr int kDeepest = 64;  // what the library does with values, such as to show them, recurses
        if (depth > kDeepest) throw IoError("it is nested more than " + std::to_string(kDeepest) + " deep");
        if (event == json::parse_event_t::object_start) open.emplace_back();
        if (event == json::parse_event_t::object_end) open.pop_back();
        if (event == json::parse_event_t::key && !open.back().insert(value.get<std::string>()).second)
            throw IoError("'" + value.get<std::string>() + "' is given twice in one object");
        return true;
    };
    try {
        return json::parse(text, once);
    } catch (const json::exception& error) {
        throw IoError("it is not valid JSON: " + withoutPrefix(error.what()));
    }
}

JsonFields::JsonFields(const json& object, std::string where) : object_(object), where_(std::move(where)) {
    if (!object_.is_object())
        throw IoError((where_.empty() ? "the file" : where_.substr(0, where_.size() - 1)) + " must be an object { }");
}

const json& JsonFields::at(const std::string& key) {
    if (!has(key)) throw IoError("'" + where_ + key + "' is missing");
    taken_.insert(key);
    return object_[key];
}

double JsonFields::number(const std::string& key) {
    const json& value = at(key);
    if (!value.is_number()) fail(key, "a number");
    return value.get<double>();
}

int JsonFields::integer(const std::string& key) {
    const json& value = at(key);
    const bool good = value.is_number_integer() && value.get<double>() >= std::numeric_limits<int>::min() &&
                      value.get<double>() <= std::numeric_limits<int>::max();
    if (!good) fail(key, "a whole number");
    return value.get<int>();
}

std::string JsonFields::text(const std::string& key) {
    const json& value = at(key);
    if (!value.is_string()) fail(key, "a text");
    return value.get<std::string>();
}

Vec3 JsonFields::vector(const std::string& key) {
    const json& value = at(key);
    if (!value.is_array() || value.size() != 3 || !value[0].is_number() || !value[1].is_number() ||
        !value[2].is_number())
        fail(key, "an array of three numbers");
    return Vec3(value[0].get<double>(), value[1].get<double>(), value[2].get<double>());
}

void JsonFields::requireNoMore() const {
    for (const auto& item : object_.items())
        if (!taken_.count(item.key())) throw IoError("'" + where_ + item.key() + "' is not known here");
}

void JsonFields::fail(const std::string& key, const std::string& what) const {
    throw IoError("'" + where_ + key + "' must be " + what);
}

}  // namespace raysweep
