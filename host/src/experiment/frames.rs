//! The frames that pictures of stages are made of: a rendered one, and one that the user names.

use super::{Context, trees::tree};
use crate::{error::InputError, frame::Frame, fruit::Fruit, image::ColourImage};

/// A frame to show.
pub(super) struct Shown {
    /// Begins the names of its pictures.
    pub(super) prefix: &'static str,
    /// Colour and depth.
    pub(super) frame: Frame,
    /// What hangs in it.
    pub(super) fruit: Fruit,
}

/// The rendered frame of the first seed, and the given one.
///
/// # Errors
/// A given frame that cannot be read.
pub(super) fn frames(context: &Context) -> Result<Vec<Shown>, InputError> {
    let mut frames =
        vec![Shown { prefix: "rendered", frame: tree(context.seed).frame, fruit: Fruit::Jujube }];
    if let Some(folder) = &context.frame {
        frames.push(Shown { prefix: "given", frame: Frame::read(folder)?, fruit: context.fruit });
    }
    Ok(frames)
}

/// Half as wide and high, each pixel the mean of four: a report of full-size pictures would be tens of megabytes. Small
/// pictures stay as they are.
pub(super) fn halved(image: ColourImage) -> ColourImage {
    if image.width < 1200 {
        return image;
    }
    let (width, height) = (image.width / 2, image.height / 2);
    let mean = |u: usize, v: usize| {
        let at = |du: usize, dv: usize| image.pixels[(2 * v + dv) * image.width + 2 * u + du];
        let four = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
        std::array::from_fn(|k| (four.iter().map(|pixel| u32::from(pixel[k])).sum::<u32>() / 4) as u8)
    };
    let pixels = (0..height).flat_map(|v| (0..width).map(move |u| (u, v))).map(|(u, v)| mean(u, v)).collect();
    ColourImage { width, height, pixels }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halving_takes_the_mean_of_four() {
        let mut image = ColourImage::filled(1201, 3, [8; 3]);
        image.set(0, 0, [40, 8, 8]);
        let half = halved(image);
        assert_eq!((half.width, half.height, half.pixels.len()), (600, 1, 600));
        assert_eq!((half.pixels[0], half.pixels[1]), ([16, 8, 8], [8; 3]));
        let small = ColourImage::filled(30, 3, [8; 3]);
        assert_eq!(halved(small.clone()), small);
    }
}
