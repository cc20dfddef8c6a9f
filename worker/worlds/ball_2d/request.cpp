#include "worker/worlds/ball_2d/request.h"

namespace sleight::worlds::ball_2d {
namespace {

void bind_world(request::Binder& world, WorldParameters& p) {
  world.number("diameter_m", p.diameter_m,
               {.minimum = 0.001,
                .maximum = 1000,
                .unit = "m",
                .help = "ball diameter D; only scales the picture"});
  world.number("gravity_mps2", p.gravity_mps2,
               {.minimum = 0.01,
                .maximum = 1000,
                .unit = "m/s2",
                .help = "gravitational acceleration; only scales time"});
  world.number("drop_height_diameters", p.drop_height_diameters,
               {.minimum = 0.01,
                .maximum = 10000,
                .unit = "D",
                .help = "fall height before the first collision"});
  world.integer(
      "collisions", p.collisions,
      {.minimum = 1,
       .maximum = k_collisions_max,
       .help = "number of collisions with random normals; the ball lands at the next collision"});
  // A standard deviation near 0 would leave nothing to direct, and 0 has no density.
  world.angle_deg("normal_sd_deg", p.normal_sd_rad,
                  {.minimum = 0.001,
                   .maximum = 45,
                   .help = "standard deviation of each normal's angle from the vertical"});
  world.number("restitution", p.restitution,
               {.minimum = 0,
                .above_minimum = true,
                .maximum = 1,
                .help = "coefficient of restitution, along the normal"});
}

void bind_constraint(request::Binder& constraint, ConstraintParameters& p) {
  constraint.number("target_diameters", p.target_diameters,
                    {.minimum = -10000,
                     .maximum = 10000,
                     .unit = "D",
                     .help = "target position, relative to the point below the start"});
  constraint.number("sigma_diameters", p.sigma_diameters,
                    {.minimum = 1e-6,
                     .maximum = 10000,
                     .unit = "D",
                     .help = "standard deviation of the landing point around the target"});
  constraint.number(
      "tolerance_diameters", p.tolerance_diameters,
      {.minimum = 1e-6,
       .maximum = 10000,
       .unit = "D",
       .help = "maximum distance from the target at which the constraint is satisfied"});
}

void bind_proposal(request::Binder& sampler, ProposalParameters& p) {
  sampler.number("change_probability", p.change_probability,
                 {.minimum = 0,
                  .above_minimum = true,
                  .maximum = 1,
                  .help = "probability that a proposal changes a given normal"});
  sampler.angle_deg(
      "change_half_width_deg", p.change_half_width_rad,
      {.minimum = 0.001,
       .maximum = 180,
       .help = "maximum change of a normal's angle; the change is uniformly distributed"});
}

void bind(request::WorldSections& sections, Parameters& parameters) {
  bind_world(sections.world, parameters.world);
  bind_constraint(sections.constraint, parameters.constraint);
  bind_proposal(sections.sampler, parameters.proposal);
}

}  // namespace

request::WorldBinding request_binding() {
  return request::bind_world<Parameters>(
      "ball_2d", "a ball bounces on a table in two dimensions and lands near a target", &bind);
}

}  // namespace sleight::worlds::ball_2d
