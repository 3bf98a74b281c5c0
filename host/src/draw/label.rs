//! Labels beside the targets, and the legend below the picture.
//!
//! A label is tried at places around its target, near ones first, and goes where it covers least of other labels and
//! targets and stays inside the picture: greedy, in the order of the targets, so the same result gives the same
//! picture.

use super::canvas::{Canvas, Colour, Frame, Position, Stroke};
use super::{DARK, Overlay, REASON, Scale, TEXT, UNCERTAINTY, colour_of, refused_stroke};
use crate::image::ColourImage;

/// Words that belong to a target.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Label {
    /// Frame around the target.
    pub(crate) around: Frame,
    /// Its outline, finite, at least one position.
    pub(crate) outline: Vec<Position>,
    /// Its colour, also that of the title.
    pub(crate) colour: Colour,
    /// Of a target that matters less: drawn fainter, under the others.
    pub(crate) is_quiet: bool,
    /// First line, bold unless quiet.
    pub(crate) title: String,
    /// Second line, left out when empty.
    pub(crate) words: String,
    /// Colour of the second line.
    pub(crate) words_colour: Colour,
}

/// Places and draws labels within a part of the canvas.
pub(crate) fn draw_labels(canvas: &mut Canvas, labels: &[Label], within: &Frame, scale: &Scale) {
    let places = placed(labels, within, scale);
    let layers = || {
        [true, false]
            .into_iter()
            .flat_map(|layer| labels.iter().zip(&places).filter(move |(label, _)| label.is_quiet == layer))
    };
    for (label, place) in layers() {
        draw_leader(canvas, label, place, scale);
    }
    for (label, place) in layers() {
        draw_label(canvas, label, place, scale);
    }
}

fn size_of(label: &Label, scale: &Scale) -> (f64, f64) {
    let padding = scale.line_px * 2.0;
    let width = scale.bold.width_of(&label.title).max(scale.font.width_of(&label.words));
    let lines = if label.words.is_empty() { 1.0 } else { 2.0 };
    // The colour bar at the left is as wide as the padding.
    (width + 4.0 * padding, lines * scale.font.line_height() + padding)
}

/// A place for each label.
fn placed(labels: &[Label], within: &Frame, scale: &Scale) -> Vec<Frame> {
    let mut places: Vec<Frame> = Vec::new();
    for (own, label) in labels.iter().enumerate() {
        // Square pixels that are lost or covered. A longer leader is worth a little.
        let cost = |place: &Frame| {
            let others = labels.iter().enumerate().filter(|&(other, _)| other != own);
            let outside = place.width * place.height - place.overlap(within);
            let on_labels: f64 = places.iter().map(|other| place.overlap(other)).sum();
            let on_targets: f64 = others.map(|(_, other)| place.overlap(&other.around)).sum();
            let leader = 2.0 * scale.line_px * place.distance(&label.around);
            8.0 * outside + 6.0 * on_labels + on_targets + 2.0 * place.overlap(&label.around) + leader
        };
        let mut best: Option<(f64, Frame)> = None;
        for place in candidates(&label.around, size_of(label, scale), scale) {
            let cost = cost(&place);
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, place));
            }
        }
        places.push(best.map_or(label.around, |(_, place)| place));
    }
    places
}

/// Eight places around a target on each of many rings, nearest ring first.
fn candidates(around: &Frame, (width, height): (f64, f64), scale: &Scale) -> impl Iterator<Item = Frame> {
    let Frame { left, top, width: across, height: down } = *around;
    let gap = 4.0 * scale.line_px;
    let step = height + gap;
    (0..15).map(|half| 0.5 * f64::from(half)).flat_map(move |ring| {
        let reach = gap + ring * step;
        let (before_x, after_x) = (left - reach - width, left + across + reach);
        let (before_y, after_y) = (top - reach - height, top + down + reach);
        let (middle_x, middle_y) = (left + (across - width) / 2.0, top + (down - height) / 2.0);
        // Beside before above before below; the diagonal places hug the target's corners.
        [
            (after_x, middle_y),
            (before_x, middle_y),
            (middle_x, before_y),
            (middle_x, after_y),
            (left + across, before_y + gap),
            (left + across, after_y - gap),
            (left - width, before_y + gap),
            (left - width, after_y - gap),
        ]
        .map(|(x, y)| Frame { left: x, top: y, width, height })
    })
}

/// A thin line from the label to the nearest point of the outline, unless they touch.
fn draw_leader(canvas: &mut Canvas, label: &Label, place: &Frame, scale: &Scale) {
    let nearest_in_place = |p: &Position| {
        (p.0.clamp(place.left, place.left + place.width), p.1.clamp(place.top, place.top + place.height))
    };
    let distance = |p: &Position| {
        let q = nearest_in_place(p);
        (p.0 - q.0).hypot(p.1 - q.1)
    };
    let nearest = label.outline.iter().min_by(|p, q| distance(p).total_cmp(&distance(q)));
    if let Some(end) = nearest.filter(|end| distance(end) > 2.0 * scale.line_px) {
        let opacity = if label.is_quiet { 0.5 } else { 1.0 };
        let stroke = Stroke { opacity, ..Stroke::solid(0.5 * scale.line_px, label.colour) };
        canvas.stroke_with_halo(&[nearest_in_place(end), *end], &stroke);
    }
}

fn draw_label(canvas: &mut Canvas, label: &Label, place: &Frame, scale: &Scale) {
    let padding = scale.line_px * 2.0;
    canvas.fill(place, padding, DARK, if label.is_quiet { 0.5 } else { 0.82 });
    let bar = Frame {
        left: place.left + padding * 0.5,
        top: place.top + padding * 0.7,
        width: padding * 0.8,
        height: place.height - padding * 1.4,
    };
    canvas.fill(&bar, padding * 0.4, label.colour, if label.is_quiet { 0.5 } else { 1.0 });
    let (x, y) = (place.left + 2.3 * padding, place.top + padding / 2.0);
    let title = if label.is_quiet { &scale.font } else { &scale.bold };
    title.draw(canvas, (x, y), &label.title, label.colour);
    scale.font.draw(canvas, (x, y + scale.font.line_height()), &label.words, label.words_colour);
}

/// The picture with a strip below that says what the lines mean and how many there are of each, and the captions.
pub(crate) fn with_legend(
    picture: &ColourImage,
    overlays: &[Overlay],
    captions: &[&str],
    scale: &Scale,
) -> ColourImage {
    let refused = overlays.iter().filter(|overlay| overlay.is_refused()).count();
    let found = overlays.len() - refused;
    let line = scale.line_px;
    let mut entries = vec![Entry {
        sample: Some(Stroke::solid(line, colour_of(1))),
        text: format!("found {found}"),
        colour: TEXT,
    }];
    if refused > 0 {
        entries.push(Entry {
            sample: Some(refused_stroke(scale)),
            text: format!("refused {refused}"),
            colour: REASON,
        });
    }
    let is_sure = |overlay: &Overlay| overlay.centre_covariance_mm2.is_some() && !overlay.is_refused();
    if overlays.iter().any(is_sure) {
        entries.push(Entry {
            sample: Some(Stroke::solid(0.6 * line, UNCERTAINTY)),
            text: "holds the centre (95 %)".into(),
            colour: TEXT,
        });
        entries.push(Entry {
            sample: None,
            text: "semi-axes ± sigma of the centre in mm".into(),
            colour: TEXT,
        });
    } else {
        entries.push(Entry { sample: None, text: "semi-axes in mm".into(), colour: TEXT });
    }
    entries.extend(captions.iter().map(|&text| Entry { sample: None, text: text.into(), colour: TEXT }));

    let margin = scale.font.line_height() / 2.0;
    let sample_px = 16.0 * line;
    let width_of = |entry: &Entry| {
        scale.font.width_of(&entry.text) + if entry.sample.is_some() { sample_px + margin / 2.0 } else { 0.0 }
    };
    // Entries flow from left to right and wrap like words.
    let (mut x, mut row) = (margin, 0.0);
    let mut corners = Vec::new();
    for entry in &entries {
        if x > margin && x + width_of(entry) + margin > picture.width as f64 {
            (x, row) = (margin, row + 1.0);
        }
        corners.push((x, row));
        x += width_of(entry) + 2.0 * margin;
    }
    let row_height = scale.font.line_height() * 1.2;
    let strip = ((row + 1.0) * row_height + margin).ceil() as usize;
    let mut pixels = picture.pixels.clone();
    pixels.resize(picture.width * (picture.height + strip), DARK);
    let mut canvas =
        Canvas::new(ColourImage { width: picture.width, height: picture.height + strip, pixels });
    for (entry, (x, row)) in entries.iter().zip(corners) {
        let y = picture.height as f64 + margin / 2.0 + row * row_height;
        let mut text_x = x;
        if let Some(stroke) = &entry.sample {
            let middle = y + scale.font.line_height() / 2.0;
            canvas.stroke(&[(x, middle), (x + sample_px, middle)], stroke);
            text_x += sample_px + margin / 2.0;
        }
        scale.font.draw(&mut canvas, (text_x, y), &entry.text, entry.colour);
    }
    canvas.finish()
}

/// A line sample with words.
struct Entry {
    sample: Option<Stroke>,
    text: String,
    colour: Colour,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn label(left: f64, top: f64) -> Label {
        Label {
            around: Frame { left, top, width: 40.0, height: 40.0 },
            outline: vec![(left, top), (left + 40.0, top + 40.0)],
            colour: [255; 3],
            is_quiet: false,
            title: "1  21.8 × 10.9 × 10.7 mm".into(),
            words: "77 %".into(),
            words_colour: TEXT,
        }
    }

    #[test]
    fn labels_stay_inside_and_apart() {
        let scale = Scale::of(1280, 960, 7);
        let corners = [
            (5.0, 5.0),
            (1230.0, 5.0),
            (5.0, 900.0),
            (1230.0, 900.0),
            (600.0, 400.0),
            (650.0, 410.0),
            (625.0, 450.0),
        ];
        let labels: Vec<Label> = corners.iter().map(|&(x, y)| label(x, y)).collect();
        let picture = Frame { left: 0.0, top: 0.0, width: 1280.0, height: 960.0 };
        let places = placed(&labels, &picture, &scale);
        for (k, place) in places.iter().enumerate() {
            assert!(
                place.overlap(&picture) > 0.999 * place.width * place.height,
                "{place:?} leaves the picture"
            );
            for other in &places[..k] {
                assert_eq!(place.overlap(other), 0.0, "{place:?} covers {other:?}");
            }
            for target in &labels {
                assert_eq!(place.overlap(&target.around), 0.0, "{place:?} covers {:?}", target.around);
            }
        }
    }

    #[test]
    fn the_legend_wraps() {
        let picture = ColourImage::filled(700, 100, [0; 3]);
        let scale = Scale::of(700, 100, 0);
        let short = with_legend(&picture, &[], &["one line"], &scale);
        let long = with_legend(&picture, &[], &["a long caption"; 5], &scale);
        assert!(long.height > short.height && short.height > picture.height);
        assert_eq!(long.pixels.len(), long.width * long.height);
    }
}
