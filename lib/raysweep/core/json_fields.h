/// JSON files, with errors that name the field. For sources alone: what includes it reads the JSON library as well.
#pragma once

#include "raysweep/core/types.h"

#include <nlohmann/json.hpp>

#include <set>
#include <string>

namespace raysweep {

/// @throw IoError if `text` is not valid JSON, is nested very deep, or an object has one key twice (the JSON library
/// would keep the last).
nlohmann::json parseJson(const std::string& text);

/// The fields of one JSON object, which must outlive this. All but `has` throw IoError if the field is missing or of
/// another type.
class JsonFields {
  public:
    /// @param where stands before its keys in messages: "views[3]."
    /// @throw IoError if it is no object
    JsonFields(const nlohmann::json& object, std::string where);

    bool has(const std::string& key) const { return object_.contains(key); }
    const nlohmann::json& at(const std::string& key);
    double number(const std::string& key);
    int integer(const std::string& key);
    std::string text(const std::string& key);
    Vec3 vector(const std::string& key);

    /// To be called when all fields that there can be were taken. @throw IoError naming one that was not
    void requireNoMore() const;

    /// @throw IoError "'FIELD' must be WHAT"
    [[noreturn]] void fail(const std::string& key, const std::string& what) const;

  private:
    const nlohmann::json& object_;
    std::string where_;
    std::set<std::string> taken_;
};

}  // namespace raysweep
