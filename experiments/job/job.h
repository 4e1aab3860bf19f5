// The complete request for one render, from a job file and the command line.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "display/services/parameters.h"
#include "experiments/job/output_requests.h"
#include "experiments/job/pass_request.h"
#include "lpe/channels/channel_file.h"
#include "lpe/event.h"
#include "lpe/language/names.h"
#include "transport/render/render.h"
#include "transport/scene/effects/effects.h"
#include "transport/scene/missing_files.h"
#include "transport/scene/scene_description.h"

namespace raylex::experiments {

/// One light path expression channel, from --lpe or a [[channel]] table.
struct ExpressionRequest {
    std::string name;
    std::string expression;
    lpe::Dialect dialect = lpe::Dialect::renderman;
    SourceLocation location;                      ///< of the expression's first character, for errors
    std::shared_ptr<const lpe::SourceMap> map{};  ///< source position of each character, if it comes from a file
};

/// A geometric AOV by its standard name.
struct AovRequest {
    std::string name;
    SourceLocation location;
};

/// A partition that the job declares. It is proved before a ray is traced.
struct PartitionRequest {
    std::string name;
    std::string of;  ///< channel that is split; empty = beauty
    std::vector<std::string> channels;
    std::string rest;  ///< not empty: the name of a layer with all other light
    SourceLocation location;
};

/// A request for layers by sampling technique, from --techniques or `techniques` in [channels].
struct TechniqueRequest {
    std::vector<std::string> channels;  ///< "beauty", or channels of the job
    SourceLocation location;
};
/// Parses "pyramid" (of the beauty), or "pyramid:" and names of channels separated by commas.
Result<TechniqueRequest> parse_techniques(const std::string& text, const SourceLocation& where);

/// A request to render only some of the image's samples and to write their sums to a file for `raylex merge`.
struct ShardRequest {
    unsigned part = 1, parts = 1;  ///< number of the part, counted from 1, and number of parts
    std::string record;            ///< file for the sums
};

/// A plugin in the job file.
struct PluginRequest {
    std::string file;
    SourceLocation location;
};

struct Job {
    std::string scene_file;
    std::string job_file, job_text;  ///< the TOML source of the job; empty for a scene file
    std::string output, preview, statistics;
    std::string ocio_config, rendering_space, display, view;
    double exposure = 0;                  ///< exposure of previews of light, in stops
    double checkpoint_seconds = 0;        ///< between checkpoints; 0 = none
    bool resume = false;                  ///< continue from the checkpoint beside the output
    bool guide_only = false;              ///< trains the guide for its file instead of rendering
    std::optional<ShardRequest> shard{};  ///< renders a shard instead of the image
    transport::MissingFiles missing = transport::MissingFiles::refused;  ///< treatment of missing files of the scene
    bool texture_rules = false;   ///< converts image textures by the colour config's file rules instead of pbrt's
    unsigned shard_commands = 0;  ///< not 0: prints the commands of this many shards instead of rendering
    OutputRequests outputs;
    bool shipped_partition = false;  ///< adds the shipped partition's channels
    bool light_groups = false;       ///< adds one layer per light group and one for the lights without a group
    std::optional<TechniqueRequest> techniques;
    transport::RenderSettings settings;  ///< `channels.list` is filled by plan_channels()
    transport::EffectChoices effects;    ///< applied by load_job_scene()
    bool show_effects = false;           ///< prints all effects with the reason for each
    std::vector<ExpressionRequest> expressions;
    std::vector<AovRequest> aovs;
    std::vector<display::ChannelDefinition> declared;  ///< channels without expressions, which plugins write to
    std::vector<PluginRequest> plugins;                ///< loaded by read_job()
    std::vector<PartitionRequest> partitions;
    std::vector<PassRequest> passes;  ///< empty: one method renders all paths
    bool layer_passes = false;        ///< adds a layer for each pass
    bool measure_refuted = false;     ///< reports and measures partitions that do not hold, instead of refusing them
    lpe::MacroTable macros;           ///< names that the job's expressions may use
    std::vector<lpe::LobeOption> lobe_options;  ///< as in the file; settings.labels.lobe_slots has the resulting slots
    std::vector<transport::LabelRule> label_rules;
};

/// Parses "renderman" or "osl". Anything else is an Error at `where`.
Result<lpe::Dialect> parse_dialect(const std::string& name, const SourceLocation& where);
/// Removes a prefix "osl:" or "renderman:" from the expression and sets its dialect. Such a prefix has no other meaning
/// in either dialect.
void take_dialect_mark(std::string& expression, lpe::Dialect& dialect);

/// Parses "WxH" with both numbers between 1 and 65536.
Result<std::array<int, 2>> parse_resolution(const std::string& text, const SourceLocation& where);
/// Parses "X0,Y0,X1,Y1", non-negative integers with X0 < X1 and Y0 < Y1.
Result<display::PixelRegion> parse_crop(const std::string& text, const SourceLocation& where);

/// Adds a kind of cryptomatte by name. An unknown or duplicate kind is an Error at `where`.
Status add_cryptomatte(const std::string& name, const SourceLocation& where, transport::MatteSettings& mattes);

/// Makes a request for a further layer of a channel, from --layer or [[layer]]. Errors at `where`: an invalid layer
/// name, an unknown rule.
Result<display::LayerRequest> read_layer_request(const std::string& name, const std::string& channel,
                                                 const std::string& rule, const SourceLocation& where);

/// Checks a layer name. A name has letters, digits and _ - . : and begins with a letter or _; it has at most 128 bytes.
/// The names of the beauty (beauty, rgba, R, G, B, A, Y) and of cryptomattes (CryptoObject...) are reserved.
Status check_layer_name(const std::string& name, const SourceLocation& where);

}  // namespace raylex::experiments
