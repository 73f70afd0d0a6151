// SPDX-License-Identifier: Apache-2.0
#include "form_choice.h"

#include <algorithm>
#include <numeric>

#include <octet/core/base/error.h>

namespace octet {

FormChoice::FormChoice(const ControlAsset& asset, const BakeOptions& options, const Target& target)
    : asset_(asset), options_(options), target_(target) {
  if (options_.forms.empty()) {
    takeAll();
  } else {
    takeNamed();
  }
  findVelocity();
  checkNames();
}

void FormChoice::takeAll() {
  for (const Form& form : asset_.forms) {
    if (!options_.derivative || form.degree < 3) forms_.push_back(&form);
  }
  if (forms_.empty()) {
    throw InputError("", options_.derivative ? "the asset has no form with a derivative"
                                             : "the asset has no forms to bake");
  }
}

void FormChoice::takeNamed() {
  for (const std::string& name : options_.forms) {
    const Form& form = asset_.form(name);
    if (options_.derivative && form.degree == 3) {
      throw InputError("", "form \"" + name + "\" has degree 3 and no derivative");
    }
    if (std::find(forms_.begin(), forms_.end(), &form) == forms_.end()) forms_.push_back(&form);
  }
}

/// The velocity, which a target looks for by name: the first flux form, else the first vector.
void FormChoice::findVelocity() {
  for (const int degree : {2, 1}) {
    for (const Form* form : forms_) {
      if (!velocity_ && bakedDegree(*form) == degree) velocity_ = form;
    }
  }
}

int FormChoice::bakedDegree(const Form& form) const {
  return form.degree + (options_.derivative ? 1 : 0);
}

void FormChoice::checkNames() const {
  for (const Form* form : forms_) {
    for (const Form* other : forms_) {
      if (form != other && gridName(*form) == gridName(*other)) {
        throw InputError("", "forms \"" + form->name + "\" and \"" + other->name +
                                 "\" would both become grid \"" + gridName(*form) +
                                 "\" for target " + target_.name + "; choose with --form");
      }
    }
  }
}

std::string FormChoice::gridName(const Form& form) const {
  return &form == velocity_ && target_.velocityName[0] ? target_.velocityName : form.name;
}

std::optional<std::vector<int>> FormChoice::frames() const {
  std::optional<std::pair<int, int>> range;
  for (const Form* form : forms_) {
    if (!form->animated()) continue;
    const int first = form->frames.begin()->first, last = form->frames.rbegin()->first;
    range = range ? std::pair{std::min(range->first, first), std::max(range->second, last)}
                  : std::pair{first, last};
  }
  if (!range) {
    if (options_.frames) throw InputError("frames", "the asset's forms are not animated");
    return std::nullopt;
  }
  if (options_.frames) {
    for (const int frame : *options_.frames) {
      if (frame >= range->first && frame <= range->second) continue;
      throw InputError("frames", "the asset has frames " + std::to_string(range->first) + "-" +
                                     std::to_string(range->second) + ", not " +
                                     std::to_string(frame));
    }
    return options_.frames;
  }
  std::vector<int> all(static_cast<std::size_t>(range->second - range->first) + 1);
  std::iota(all.begin(), all.end(), range->first);
  return all;
}

}  // namespace octet
