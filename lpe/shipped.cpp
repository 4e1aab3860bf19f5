#include "lpe/shipped.h"

#include <array>

namespace raylex::lpe {

namespace {

constexpr std::array<NamedExpression, 9> renderman_partition{{
    {"emissive", "C[<L.>O]-CB"},
    {"background", "CB"},
    {"directDiffuse", "C<RD>[<L.>O]"},
    {"indirectDiffuse", "C<RD>[DSV]+[<L.>O]"},
    {"subsurface", "C<TD>[DSV]*[<L.>O]"},
    {"directSpecular", "C<RS>[<L.>O]"},
    {"indirectSpecular", "C<RS>[DSV]+[<L.>O]"},
    {"transmissive", "C<TS>[DSV]*[<L.>O]"},
    {"volume", "CV.*"},
}};

// The layers in osl, where pass-through events are letters: they can occur anywhere and do not affect the layer.
constexpr std::array<NamedExpression, 9> osl_partition{{
    {"emissive", "C<Ts>*[LO]"},
    {"background", "C<Ts>*B"},
    {"directDiffuse", "C<Ts>*<RD><Ts>*[LOB]"},
    {"indirectDiffuse", "C<Ts>*<RD><Ts>*[DGSV][DGSsV]*[LOB]"},
    {"subsurface", "C<Ts>*<TD>[DGSsV]*[LOB]"},
    {"directSpecular", "C<Ts>*<R[GS]><Ts>*[LOB]"},
    {"indirectSpecular", "C<Ts>*<R[GS]><Ts>*[DGSV][DGSsV]*[LOB]"},
    {"transmissive", "C<Ts>*<T[GS]>[DGSsV]*[LOB]"},
    {"volume", "C<Ts>*V.*"},
}};

}  // namespace

std::span<const NamedExpression> shipped_partition(Dialect dialect) {
    if (dialect == Dialect::osl) { return osl_partition; }
    return renderman_partition;
}

std::string_view beauty_expression(Dialect dialect) {
    return dialect == Dialect::osl ? "C[DGSsV]*[LOB]" : "C[DSV]*[<L.>O]";
}

}  // namespace raylex::lpe
