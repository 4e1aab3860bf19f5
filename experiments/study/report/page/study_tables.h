// The tables of a study's page, each a piece of HTML. Formulas stand in the headers; a reason stands once below its
// table, and cells refer to it by a letter.
#pragma once

#include <string>

#include "experiments/study/report/measures/study.h"

namespace raylex::experiments {

[[nodiscard]] std::string text_cell(const std::string& text);
[[nodiscard]] std::string table(const std::string& head, const std::string& rows);

/// What the page begins with: a row per channel, a column per variant.
std::string comparison_table(const Study& study);

/// Rows are the variants, one panel per channel and region of a scene.
std::string times_table(const Study& study, const std::string& scene, const std::string& channel,
                        const std::string& region);
std::string errors_table(const Study& study, const std::string& scene, const std::string& channel,
                         const std::string& region);
std::string slopes_table(const Study& study, const std::string& scene, const std::string& channel,
                         const std::string& region);

std::string front_table(const Study& study, const std::string& scene, const std::string& channel);
std::string effects_table(const Study& study, const SceneInfo& scene);
/// Pictures of the standard deviation of every pixel; empty where there is one replicate.
std::string deviation_maps(const Study& study, const SceneInfo& scene);
/// SCENE.VARIANT.deviation.png: the standard deviation of every pixel, with one scale of colours a scene. Returns
/// how many.
Result<std::size_t> write_deviation_maps(const Study& study, const std::string& folder);
std::string bias_table(const Study& study, const SceneInfo& scene);
std::string words_list(const Study& study, const SceneInfo& scene);
std::string predictions_text(const Study& study);
std::string splits_table(const Study& study);
std::string costs_table(const Study& study);
std::string references_table(const Study& study);
std::string omissions_table(const Study& study);
std::string provenance_table(const Study& study);

}  // namespace raylex::experiments
