// SPDX-License-Identifier: BSD-3-Clause
// Where the objects stand.

#include "tests/scene_maker/placement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/random.h"
#include "tests/scene_maker/catalogue.h"
#include "tests/scene_maker/scene.h"

namespace freegs::scene_maker {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Free table between objects that don't touch, and from them to the edge
// (metres).
constexpr double kGap = 0.03;
constexpr double kEdge = 0.05;
constexpr int kDarts = 600;
constexpr int kAttempts = 50;

// Objects that touch are placed together. Offsets are in the group's frame.
struct Member {
  size_t item = 0;
  Vector3d offset = Vector3d::Zero();
  double turn = 0;  // Radians around z, against the group.
};
struct Group {
  std::vector<Member> members;
  double radius = 0;  // Radius of the circle around its origin that holds it.
  Vector2d position = Vector2d::Zero();
  double heading = 0;
};

// Extent of an item along a direction of its own frame.
double ItemSupport(const CatalogueItem& item, const Vector3d& direction) {
  double support = -std::numeric_limits<double>::infinity();
  for (const Solid& part : item.parts) {
    support = std::max(support, Support(part, direction));
  }
  return support;
}

}  // namespace

double ItemRadius(const CatalogueItem& item) {
  double radius = 0;
  for (int i = 0; i < 64; ++i) {
    const double angle = 2 * std::numbers::pi * i / 64;
    radius = std::max(radius,
                      ItemSupport(item, {std::cos(angle), std::sin(angle), 0}));
  }
  return radius;
}

namespace {

std::vector<Group> MakeGroups(const std::vector<CatalogueItem>& items) {
  std::vector<Group> groups;
  for (size_t i = 0; i < items.size(); ++i) {
    Member member{.item = i};
    if (items[i].place == Place::kAlone || groups.empty()) {
      groups.emplace_back();
    } else {
      const Member& before = groups.back().members.back();
      const CatalogueItem& other = items[before.item];
      if (items[i].place == Place::kBeside) {
        member.offset.x() = before.offset.x() +
                            ItemSupport(other, Vector3d::UnitX()) +
                            ItemSupport(items[i], -Vector3d::UnitX());
      } else {
        member.offset = before.offset;
        member.offset.z() += ItemSupport(other, Vector3d::UnitZ());
        member.turn = 2.1;
      }
    }
    Group& group = groups.back();
    group.members.push_back(member);
    group.radius = std::max(
        group.radius, member.offset.head<2>().norm() + ItemRadius(items[i]));
  }
  for (Group& group : groups) {
    // Turn about the middle of the first and last member, not about the first.
    const Vector3d middle =
        0.5 * (group.members.front().offset + group.members.back().offset);
    if (group.members.size() < 2 || middle.head<2>().norm() == 0) continue;
    group.radius = 0;
    for (Member& member : group.members) {
      member.offset.head<2>() -= middle.head<2>();
      group.radius = std::max(
          group.radius,
          member.offset.head<2>().norm() + ItemRadius(items[member.item]));
    }
  }
  return groups;
}

// Throws darts for each group, large groups first, and keeps the valid dart
// nearest to the middle of the table, which makes a loose cluster.
bool PlaceGroups(std::vector<Group>* groups, uint64_t seed, int attempt) {
  RandomStream random(seed, 7000 + static_cast<uint64_t>(attempt));
  for (size_t g = 0; g < groups->size(); ++g) {
    Group& group = (*groups)[g];
    group.heading = 2 * std::numbers::pi * random.Uniform();
    double best = std::numeric_limits<double>::infinity();
    const double reach = kTableRadius - kEdge - group.radius;
    for (int dart = 0; dart < kDarts; ++dart) {
      const double angle = 2 * std::numbers::pi * random.Uniform();
      const double distance = reach * std::sqrt(random.Uniform());
      const Vector2d position =
          distance * Vector2d(std::cos(angle), std::sin(angle));
      bool free = true;
      for (size_t other = 0; other < g && free; ++other) {
        const Group& placed = (*groups)[other];
        free = (position - placed.position).norm() >
               group.radius + placed.radius + kGap;
      }
      // The first group keeps off the middle, or all scenes would have it
      // there.
      const double score = g == 0 ? std::abs(distance - 0.2) : position.norm();
      if (free && score < best) {
        best = score;
        group.position = position;
      }
    }
    if (best == std::numeric_limits<double>::infinity()) return false;
  }
  return true;
}

}  // namespace

void PutDown(const CatalogueItem& item,
             const Eigen::Matrix3d& rotation,
             const Vector3d& origin,
             int id,
             SceneObject* object,
             std::vector<Solid>* solids) {
  object->id = id;
  object->label = item.label;
  object->kind = item.kind;
  object->obb.rotation = rotation;
  CatalogueItem posed = item;
  double volume = 0;
  for (Solid& part : posed.parts) {
    part.rotation = rotation * part.rotation;
    part.centre = rotation * part.centre + origin;
    part.object_id = id;
    volume += Volume(part);
    object->centroid += Volume(part) * Centroid(part);
    solids->push_back(part);
  }
  object->centroid /= volume;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d unit = Vector3d::Unit(axis);
    object->aabb.max[axis] = ItemSupport(posed, unit);
    object->aabb.min[axis] = -ItemSupport(posed, -unit);
    const Vector3d own = rotation * unit;
    const double high = ItemSupport(posed, own);
    const double low = -ItemSupport(posed, -own);
    object->obb.size[axis] = high - low;
    object->obb.centre += 0.5 * (high + low) * own;
  }
}

namespace {

void AddChairs(Scene* scene) {
  CatalogueItem chair =
      MakeChair(scene->options.textured,
                static_cast<uint32_t>(scene->options.seed) * 131u + 17u);
  const std::string label = chair.label;
  for (size_t i = 0; i < kChairs.size(); ++i) {
    chair.label = (i == 0 ? "left " : "right ") + label;
    scene->objects.emplace_back();
    PutDown(chair,
            Eigen::AngleAxisd(kChairs[i].heading, Vector3d::UnitZ())
                .toRotationMatrix(),
            {kChairs[i].x, 0, 0},
            static_cast<int>(i) + 1,
            &scene->objects.back(),
            &scene->solids);
  }
}

}  // namespace

Status AddObjects(Scene* scene) {
  const SceneMakerOptions& options = scene->options;
  if (options.subject == Subject::kChairs) AddChairs(scene);
  if (options.subject != Subject::kTable &&
      options.subject != Subject::kStudio) {
    return Status();
  }
  std::vector<CatalogueItem> items = MakeCatalogue(
      options.textured, static_cast<uint32_t>(options.seed) * 131u + 17u);
  items.resize(static_cast<size_t>(options.objects));
  std::vector<Group> groups = MakeGroups(items);
  std::stable_sort(
      groups.begin(), groups.end(), [](const Group& a, const Group& b) {
        return a.radius > b.radius;
      });
  bool placed = false;
  for (int attempt = 0; attempt < kAttempts && !placed; ++attempt) {
    placed = PlaceGroups(&groups, options.seed, attempt);
  }
  if (!placed) return InternalError("the objects do not fit on the table");

  scene->objects.resize(items.size());
  for (const Group& group : groups) {
    const Eigen::Matrix3d group_rotation =
        Eigen::AngleAxisd(group.heading, Vector3d::UnitZ()).toRotationMatrix();
    for (const Member& member : group.members) {
      const CatalogueItem& item = items[member.item];
      const Eigen::Matrix3d rotation =
          group_rotation *
          Eigen::AngleAxisd(member.turn, Vector3d::UnitZ()).toRotationMatrix();
      const Vector3d origin =
          Vector3d(group.position.x(), group.position.y(), kTableHeight) +
          group_rotation * member.offset;

      PutDown(item,
              rotation,
              origin,
              static_cast<int>(member.item) + 1,
              &scene->objects[member.item],
              &scene->solids);
    }
    for (size_t k = 1; k < group.members.size(); ++k) {
      scene->touching.emplace_back(items[group.members[k - 1].item].label,
                                   items[group.members[k].item].label);
    }
  }
  return Status();
}

}  // namespace freegs::scene_maker
