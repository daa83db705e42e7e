//! What of a scene goes into the keys of stages: whole sections, so that a field that is added later
//! counts until it is named here as one that changes nothing.

use serde::Serialize;
use serde_json::{Value, json};

use super::dataset_kind::DatasetKind;
use crate::profile::Profile;
use crate::scene::{ContactSpec, Scene};

/// Version of the datasets' content.
const DATASET_VERSION: u32 = 1;

/// What the limb depends on. The deck counts by its bytes, not by its path; what a wall is solved as
/// counts where it is solved.
pub(crate) fn limb(scene: &Scene, deck_hash: &str) -> Value {
    let mut key = json!({
        "deck": deck_hash,
        "geometry": all_but(&scene.geometry, &["solid_deck", "skin", "skin_gltf", "solver"]),
        "material": scene.material,
        "mount": scene.mount,
        "contact": all_but(&scene.contact, &["force_range_n", "min_spacing_m", "max_contacts"]),
        "gauges": scene.gauges,
    });
    if let Some(flange) = scene.loads.as_ref().and_then(|loads| loads.flange.as_ref()) {
        key["flange"] = json!(flange.at);
    }
    key
}

/// What sets the rig's limb apart from it; `own_deck_hash` of a rig with a mesh of its own.
pub(crate) fn rig(scene: &Scene, own_deck_hash: Option<&str>) -> Value {
    json!({
        "deck": own_deck_hash,
        "rig": all_but(&scene.rig, &["electronics", "presses", "live"]),
    })
}

/// How contacts are drawn, a given number at a time.
pub(super) fn draws(contact: &ContactSpec) -> Value {
    all_but(contact, &["max_contacts"])
}

/// What a dataset depends on: the keys of the `[compliance, rig]` stages that it superposes, how
/// contacts are drawn, how many and with which seeds.
pub(super) fn dataset(
    kind: DatasetKind,
    [compliance, rig]: [&String; 2],
    scene: &Scene,
    profile: &Profile,
) -> Value {
    let draws = match kind {
        DatasetKind::Simulated { n_contacts: 1 } => json!([profile.n_single, scene.seed]),
        DatasetKind::Simulated { .. } => json!([profile.n_multi, scene.seed]),
        DatasetKind::RigSingle | DatasetKind::RigDouble => {
            let n = [profile.n_real_single, profile.n_pairs, profile.n_amplitudes];
            json!([rig, scene.rig.electronics, scene.rig.presses, n])
        }
    };
    json!({
        "version": DATASET_VERSION,
        "kind": kind,
        "limb": compliance,
        "contact": self::draws(&scene.contact),
        "draws": draws,
    })
}

/// Settings as they are written, without the fields that change nothing.
pub(super) fn all_but(settings: &impl Serialize, without: &[&str]) -> Value {
    let mut settings = json!(settings);
    if let Value::Object(fields) = &mut settings {
        fields.retain(|name, _| !without.contains(&name.as_str()));
    }
    settings
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde::de::DeserializeOwned;

    use super::*;
    use crate::scene::{LiveSpec, MaterialSpec, read_scene};

    /// Texts that some field of a scene may have.
    const WORDS: [&str; 6] = ["m", "mm", "normal", "radial", "contacts", "map"];

    /// Paths of all leaves: numbers, texts, flags, nothing.
    fn leaves(value: &Value, path: &str, found: &mut Vec<String>) {
        match value {
            Value::Object(fields) => {
                fields.iter().for_each(|(name, v)| leaves(v, &format!("{path}/{name}"), found));
            }
            Value::Array(items) => {
                let items = items.iter().enumerate();
                items.for_each(|(i, v)| leaves(v, &format!("{path}/{i}"), found));
            }
            _ => found.push(path.to_owned()),
        }
    }

    /// The settings with another value at `path`, which the type still allows.
    fn changed<T: DeserializeOwned>(settings: &Value, path: &str) -> Option<T> {
        let now = settings.pointer(path).unwrap();
        let others = match now {
            Value::Number(n) if n.is_f64() => vec![json!(n.as_f64().unwrap() + 0.125)],
            Value::Number(n) => vec![json!(n.as_u64().unwrap() + 1)],
            Value::Bool(b) => vec![json!(!b)],
            Value::String(text) => {
                let words = WORDS.iter().filter(|word| *word != text).map(|word| json!(word));
                [json!(format!("{text}x"))].into_iter().chain(words).collect()
            }
            other => panic!("{path}: {other}"),
        };
        let with = |other: Value| {
            let mut settings = settings.clone();
            *settings.pointer_mut(path).unwrap() = other;
            serde_json::from_value(settings).ok()
        };
        others.into_iter().find_map(with)
    }

    /// A scene that names all there is.
    fn scene() -> Scene {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shin");
        let mut scene = read_scene(&folder.join("scene.json")).unwrap();
        scene.geometry.skin_gltf = Some("skin.glb".into());
        scene.material =
            Some(MaterialSpec { youngs_modulus_pa: 2e9, poissons_ratio: 0.3, density_kg_m3: 1e3 });
        scene.rig.live = Some(LiveSpec { flicker_ue: 0.5, ..LiveSpec::default() });
        scene
    }

    /// Every leaf under `sections` changes the key but for those under `without`, which don't.
    #[track_caller]
    fn check(key: impl Fn(&Scene) -> Value, sections: &[&str], without: &[&str]) {
        let settings = json!(scene());
        let (own, mut found) = (key(&scene()), vec![]);
        leaves(&settings, "", &mut found);
        assert!(found.len() > 60, "{found:?}");
        let is_in = |path: &str, all: &[&str]| all.iter().any(|s| path.starts_with(s));
        for path in found {
            let Some(other) = changed::<Scene>(&settings, &path) else {
                assert!(path.ends_with("/kind") || path.ends_with("/rule"), "{path}");
                continue;
            };
            let counts = is_in(&path, sections) && !is_in(&path, without);
            assert_eq!(key(&other) != own, counts, "{path}");
        }
    }

    #[test]
    fn every_field_of_the_limb_changes_its_key() {
        let sections = ["/geometry", "/material", "/mount", "/contact", "/gauges"];
        let without = [
            "/geometry/solid_deck",
            "/geometry/skin_gltf",
            "/contact/force_range_n",
            "/contact/min_spacing_m",
            "/contact/max_contacts",
        ];
        check(|scene| limb(scene, "deck"), &sections, &without);
        assert_ne!(limb(&scene(), "deck"), limb(&scene(), "other"));
    }

    #[test]
    fn every_field_of_the_rigs_limb_changes_its_key() {
        let without = ["/rig/electronics", "/rig/presses", "/rig/live"];
        check(|scene| rig(scene, Some("deck")), &["/rig"], &without);
        assert_ne!(rig(&scene(), Some("deck")), rig(&scene(), Some("other")));
    }

    #[test]
    fn every_field_of_the_contacts_changes_the_key_of_their_draws() {
        check(|scene| draws(&scene.contact), &["/contact"], &["/contact/max_contacts"]);
    }

    #[test]
    fn every_field_of_a_scene_that_draws_a_dataset_changes_its_key() {
        let stages = ["limb".to_owned(), "rig".to_owned()];
        let key = |kind, scene: &Scene| dataset(kind, stages.each_ref(), scene, &Profile::quick());
        let without = ["/contact/max_contacts"];
        let simulated = DatasetKind::Simulated { n_contacts: 2 };
        check(|scene| key(simulated, scene), &["/contact", "/seed"], &without);
        for kind in [DatasetKind::RigSingle, DatasetKind::RigDouble] {
            let sections = ["/contact", "/rig/electronics", "/rig/presses"];
            check(|scene| key(kind, scene), &sections, &without);
        }
    }

    #[test]
    fn every_amount_of_a_profile_changes_the_keys_of_the_datasets_that_have_it() {
        let rig: &[&str] = &["/n_real_single", "/n_pairs", "/n_amplitudes"];
        let kinds = [
            (DatasetKind::Simulated { n_contacts: 1 }, &["/n_single"][..]),
            (DatasetKind::Simulated { n_contacts: 2 }, &["/n_multi"]),
            (DatasetKind::RigSingle, rig),
            (DatasetKind::RigDouble, rig),
        ];
        let (scene, stages) = (scene(), ["limb".to_owned(), "rig".to_owned()]);
        let profile = json!(Profile::quick());
        let amounts = profile.as_object().unwrap().keys().filter(|name| name.starts_with("n_"));
        let amounts: Vec<String> = amounts.map(|name| format!("/{name}")).collect();
        assert!(amounts.len() >= 5, "{amounts:?}");
        for (kind, own) in kinds {
            let key = |profile: &Profile| dataset(kind, stages.each_ref(), &scene, profile);
            for path in &amounts {
                let other = changed::<Profile>(&profile, path).unwrap();
                let counts = own.contains(&path.as_str());
                assert_eq!(key(&other) != key(&Profile::quick()), counts, "{kind:?} {path}");
            }
        }
    }
}
