//! Colours of the scene: what the sun and the sky make of skin, bark and leaves.
//!
//! Light is linear; [`to_display`] turns it into the 8 bits of a picture. One sun with shadows, a sky that is
//! brighter from above, a highlight, and light that shines through leaves.

use nalgebra::Vector3;

use super::fruit::{Pole, Skin};
use super::noise::{cloudy_noise, value_noise};
use super::shape::{Hit, Ray};

/// Linear red, green, blue.
pub(super) type Light = Vector3<f32>;

/// Light of the sun and of the sky from above and below.
const SUN: Light = Light::new(1.75, 1.62, 1.36);
const SKY: Light = Light::new(0.50, 0.56, 0.62);
const GROUND: Light = Light::new(0.20, 0.21, 0.13);

/// What a body is made of. `field` names its texture.
#[derive(Debug, Clone, Copy)]
pub(super) enum Material {
    Skin {
        skin: Skin,
        pole: Pole,
        field: u32,
    },
    Bark {
        brightness: f32,
        field: u32,
    },
    /// Shoots, and stalks of fruit and leaves.
    Stem {
        /// 1 in the sun's reach; less further behind. So for bark and leaves.
        brightness: f32,
    },
    Leaf {
        /// 0 deep green to 1 yellowish.
        ripeness: f32,
        /// Brown instead.
        withered: bool,
        brightness: f32,
        field: u32,
    },
}

/// Direction to the sun: from behind the camera, left and above.
pub(super) fn sunward() -> Vector3<f64> {
    Vector3::new(-0.42, -0.72, -0.55).normalize()
}

/// A surface ready to be lit.
struct Surface {
    colour: Light,
    normal: Vector3<f64>,
    gloss: f32,
    /// Share of sunlight that passes from behind, and its colour.
    through: Light,
    brightness: f32,
}

/// Light that reaches the camera along `ray` from where it hits a body. `sunlit`: the sun is in sight.
pub(super) fn shade(material: &Material, hit: &Hit, ray: &Ray, sunlit: bool) -> Light {
    let view = -ray.direction.normalize();
    let surface = surface(material, hit, ray, &view);
    let sun = sunward();
    let sunlight = if sunlit { SUN } else { Light::zeros() };
    let facing = surface.normal.dot(&sun) as f32;
    let height = (0.5 - 0.5 * surface.normal.y) as f32;
    let ambient = GROUND.lerp(&SKY, height);
    let halfway = (sun + view).normalize();
    let shine = surface.normal.dot(&halfway).max(0.0) as f32;
    let shine2 = shine * shine;
    let shine4 = shine2 * shine2;
    let shine8 = shine4 * shine4;
    let sheen = shine8 * shine8 * shine8 * shine8 * shine8 * 0.42 + shine8 * 0.055;
    // Skin turned away from the eye mirrors the sky.
    let turned = 1.0 - surface.normal.dot(&view).max(0.0) as f32;
    let rim = turned * turned * turned * turned * 0.22;
    let lit = surface.colour.component_mul(&(ambient + sunlight * facing.max(0.0)))
        + surface.through.component_mul(&sunlight) * (-facing).max(0.0)
        + sunlight * (sheen * surface.gloss * facing.max(0.0).sqrt())
        + ambient * (rim * surface.gloss);
    lit * surface.brightness
}

fn surface(material: &Material, hit: &Hit, ray: &Ray, view: &Vector3<f64>) -> Surface {
    let plain = |colour: Light, gloss: f32| Surface {
        colour,
        normal: hit.normal,
        gloss,
        through: Light::zeros(),
        brightness: 1.0,
    };
    match *material {
        Material::Skin { skin, pole, field } => plain(skin_colour(&skin, pole, field, hit), skin.gloss),
        Material::Bark { brightness, field } => {
            let place = (ray.origin + ray.direction * hit.t).coords.cast::<f32>();
            let grain = value_noise(place.component_mul(&Vector3::new(0.25, 0.8, 0.8)), field);
            let lichen = smoothstep(0.56, 0.72, 0.75 * value_noise(place * 0.08, field ^ 7) + 0.25 * grain);
            let wood = linear([0.34, 0.325, 0.26]) * (0.5 + 0.8 * grain);
            let colour = wood.lerp(&linear([0.47, 0.49, 0.41]), 0.6 * lichen);
            Surface { brightness, ..plain(colour, 0.02) }
        }
        Material::Stem { brightness } => Surface { brightness, ..plain(linear([0.42, 0.50, 0.22]), 0.1) },
        Material::Leaf { ripeness, withered, brightness, field } => {
            // Seen from its back the leaf turns its other normal to us, paler and matt.
            let front = hit.normal.dot(view) > 0.0;
            let green = linear([0.19, 0.37, 0.12]).lerp(&linear([0.37, 0.51, 0.16]), ripeness * ripeness);
            let blade = if withered { linear([0.47, 0.27, 0.13]) } else { green };
            let colour = leaf_colour(blade, field, hit);
            Surface {
                colour: if front { colour } else { colour.lerp(&linear([0.52, 0.60, 0.42]), 0.3) },
                normal: if front { hit.normal } else { -hit.normal },
                gloss: if front { 0.22 } else { 0.03 },
                through: colour.component_mul(&Light::new(1.15, 1.0, 0.35)) * 0.75,
                brightness,
            }
        }
    }
}

fn skin_colour(skin: &Skin, pole: Pole, field: u32, hit: &Hit) -> Light {
    let place = hit.local.cast::<f32>();
    let [bright, deep] = skin.colours.map(linear);
    let mottle = cloudy_noise(place * 2.2, field);
    let ripe = bright.lerp(&deep, smoothstep(0.25, 0.75, mottle));
    let unripe = value_noise(place * 1.6, field ^ 0x55) - 0.12 * place.y.abs();
    let patch = smoothstep(0.72 - skin.patch_share, 0.98 - 0.4 * skin.patch_share, unripe);
    let freckle = smoothstep(0.80, 0.95, value_noise(place * 17.0, field ^ 0x99));
    let colour = ripe.lerp(&linear(skin.patch), patch * 0.85) * (1.0 + 0.35 * freckle);
    // The pit around the stalk and the scar of the blossom at the other end.
    let along = if pole == Pole::Longest { place.x } else { place.z };
    let pit = 1.0 - 0.55 * smoothstep(0.965, 0.995, along);
    let scar = 1.0 - 0.7 * smoothstep(0.990, 0.997, -along);
    colour * (pit * scar)
}

/// The blade's colour with its tones and veins.
fn leaf_colour(blade: Light, field: u32, hit: &Hit) -> Light {
    let (along, across) = (hit.local.x as f32, hit.local.y as f32);
    let tone = 0.74 + 0.46 * value_noise(Vector3::new(along * 3.5, across * 3.5, 0.0), field);
    // Three veins run from the stalk: the middle one and one to either side; finer ones branch off.
    let width = (1.0 - along * along) * (1.0 - along / 3.0);
    let beside = (across.abs() - 0.42 * width).abs();
    let slanted = (along * 5.0 - across.abs() * 3.4 + 20.0).fract();
    let main = 1.0 - smoothstep(0.015, 0.06, across.abs());
    let side = 0.6 * (1.0 - smoothstep(0.01, 0.05, beside));
    let fine = 0.28 * (1.0 - smoothstep(0.0, 0.12, (slanted - 0.5).abs()));
    let vein = main.max(side).max(fine);
    // The two halves catch the light a little differently beyond what their fold does.
    let half = if across > 0.0 { 1.06 } else { 0.94 };
    let pale = blade.lerp(&linear([0.70, 0.78, 0.48]), 0.35);
    (blade * (tone * half)).lerp(&pale, 0.7 * vein)
}

/// Linear light of a display colour, 0..1. The curve is a square, near enough to sRGB's and the same everywhere.
pub(super) fn linear(display: [f32; 3]) -> Light {
    Light::from(display).map(|x| x * x)
}

/// Display value 0..255 of linear light, not yet rounded: bright light is compressed, not cut off.
pub(super) fn to_display(light: &Light) -> Light {
    light.map(|x| {
        let x = x.max(0.0);
        255.0 * (x * (1.0 + x * 0.12) / (0.92 + x * 0.42)).min(1.0).sqrt()
    })
}

/// 0 below `from`, 1 above `to`, smooth in between.
pub(super) fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
