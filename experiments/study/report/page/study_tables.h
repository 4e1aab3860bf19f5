// The tables of a study's page, each as HTML. Headers contain the formulas. Each reason appears once below its table,
// and cells refer to it by a letter.
#pragma once

#include <string>

#include "experiments/study/report/measures/study.h"

namespace raylex::experiments {

[[nodiscard]] std::string text_cell(const std::string& text);
[[nodiscard]] std::string table(const std::string& head, const std::string& rows);

/// Returns the first table of the page: one row per channel, one column per variant.
std::string comparison_table(const Study& study);

/// Returns a table with one row per variant, for a panel of a channel and region of a scene.
std::string times_table(const Study& study, const std::string& scene, const std::string& channel,
                        const std::string& region);
std::string errors_table(const Study& study, const std::string& scene, const std::string& channel,
                         const std::string& region);
std::string slopes_table(const Study& study, const std::string& scene, const std::string& channel,
                         const std::string& region);

std::string front_table(const Study& study, const std::string& scene, const std::string& channel);
std::string effects_table(const Study& study, const SceneInfo& scene);
/// Returns pictures of the standard deviation of every pixel; empty with one replicate.
std::string deviation_maps(const Study& study, const SceneInfo& scene);
/// Writes SCENE.VARIANT.deviation.png, the standard deviation of every pixel, with one colour scale per scene. Returns
/// the number of files.
Result<std::size_t> write_deviation_maps(const Study& study, const std::string& folder);
std::string bias_table(const Study& study, const SceneInfo& scene);
std::string counterexample_list(const Study& study, const SceneInfo& scene);
std::string predictions_text(const Study& study);
std::string splits_table(const Study& study);
std::string costs_table(const Study& study);
/// Returns a table with the error and the time of each pass; empty without passes.
std::string passes_table(const Study& study);
std::string references_table(const Study& study);
std::string omissions_table(const Study& study);
std::string provenance_table(const Study& study);

}  // namespace raylex::experiments
