//! Fig. 9: the stages of the segmentation, for a rendered frame and for one that is given with `--frame`.

use super::{
    Context, Experiment, Report,
    figure::Figure,
    frames::{Shown, frames, halved},
    table::{Column, Table, row},
};
use crate::{
    draw::colour_of,
    error::InputError,
    image::{ColourImage, LabelImage},
    segment::{
        AreaLimits, Regions, SegmentOptions, filter::gate_of_mean, hue::Gate, preset,
        regions::connected_regions,
    },
};

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "fig9",
    purpose: "The segmentation in stages: colour, mean filter, hue threshold, regions; rendered, and of a given frame.",
    run,
};

fn run(context: &Context) -> Result<Report, InputError> {
    let mut table = Table::new(
        "Pixels and regions in each stage",
        vec![
            Column::new("frame", "frame", 0),
            Column::new("stage", "stage", 0),
            Column::new("pixels", "pixels", 0),
            Column::new("regions", "regions", 0),
        ],
    );
    let mut figures = Vec::new();
    for Shown { prefix, frame, fruit } in frames(context)? {
        let options = preset(fruit.name());
        let colour = &frame.colour;
        let stages = Stages::of(colour, &options)?;
        let pixels = |mask: &LabelImage| mask.pixels.iter().filter(|&&pixel| pixel != 0).count();
        let kept = stages.kept.image.pixels.iter().filter(|&&label| label != 0).count();
        let single = connected_regions(&stages.single, AreaLimits::ALL).list.len();
        table.push(row![prefix, "threshold without mean filter", pixels(&stages.single), single]);
        table.push(row![prefix, "threshold after mean filter", pixels(&stages.mask), stages.all.list.len()]);
        table.push(row![prefix, "regions of enough area", kept, stages.kept.list.len()]);
        let masked = |mask: &LabelImage| {
            let pixel = |(&colour, &on): (&[u8; 3], &u8)| if on == 0 { [0; 3] } else { colour };
            let pixels = colour.pixels.iter().zip(&mask.pixels).map(pixel).collect();
            ColourImage { width: colour.width, height: colour.height, pixels }
        };
        let pictures = [
            ("a", "the colour image".to_owned(), colour.clone()),
            ("b", "after the mean filter".to_owned(), mean_filtered(colour, options.mean_radius_px)),
            (
                "c",
                format!("after the threshold on the hue: {} regions", stages.all.list.len()),
                masked(&stages.mask),
            ),
            ("d", format!("{} regions of enough area", stages.kept.list.len()), coloured(&stages.kept)),
        ];
        for (letter, caption, picture) in pictures {
            figures.push(Figure::picture(
                format!("{prefix}-{letter}"),
                format!("{prefix}: {caption}"),
                halved(picture),
            ));
        }
    }
    Ok(Report { tables: vec![table], figures, ..Report::default() })
}

/// What the segmentation makes on its way.
struct Stages {
    /// The threshold without a mean filter.
    single: LabelImage,
    /// The threshold with it.
    mask: LabelImage,
    all: Regions,
    kept: Regions,
}

impl Stages {
    fn of(colour: &ColourImage, options: &SegmentOptions) -> Result<Self, InputError> {
        let gate = Gate::new(&options.gate)?;
        let mask = gate_of_mean(colour, options.mean_radius_px, &gate);
        Ok(Self {
            single: gate_of_mean(colour, 0, &gate),
            all: connected_regions(&mask, AreaLimits::ALL),
            kept: connected_regions(&mask, options.area),
            mask,
        })
    }
}

/// The mean of each pixel's window, for the picture only: the pipeline gates the sums and never forms this image.
fn mean_filtered(image: &ColourImage, radius: usize) -> ColourImage {
    let reach = radius as i64;
    let window = || (-reach..=reach).flat_map(|dv| (-reach..=reach).map(move |du| (du, dv)));
    let mean = |u: i64, v: i64| {
        let inside: Vec<[u8; 3]> = window().filter_map(|(du, dv)| image.get(u + du, v + dv)).collect();
        let sum = |channel: usize| inside.iter().map(|pixel| u32::from(pixel[channel])).sum::<u32>();
        [sum(0), sum(1), sum(2)].map(|sum| (sum / inside.len() as u32) as u8)
    };
    let rows = 0..image.height as i64;
    let pixels =
        rows.flat_map(|v| (0..image.width as i64).map(move |u| (u, v))).map(|(u, v)| mean(u, v)).collect();
    ColourImage { width: image.width, height: image.height, pixels }
}

/// Each region in a colour of its own.
fn coloured(regions: &Regions) -> ColourImage {
    let colour = |&label: &u32| if label == 0 { [0; 3] } else { colour_of(label) };
    let (width, height) = (regions.image.width, regions.image.height);
    ColourImage { width, height, pixels: regions.image.pixels.iter().map(colour).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_at_the_border_is_of_what_lies_inside() {
        let mut image = ColourImage::filled(4, 3, [0; 3]);
        image.set(0, 0, [90, 40, 0]);
        let mean = mean_filtered(&image, 1);
        assert_eq!(mean.get(0, 0), Some([22, 10, 0]));
        assert_eq!(mean.get(1, 1), Some([10, 4, 0]));
        assert_eq!(mean.get(2, 2), Some([0; 3]));
        assert_eq!(mean_filtered(&image, 0), image);
    }
}
