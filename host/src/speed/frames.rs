//! A whole Kinect v2 frame, 1920x1080 colour and 512x424 depth, and its stages. The unit is a frame.

use std::hint::black_box;

use super::{race::Contender, workload};
use crate::{
    error::InputError,
    frame::{Frame, Geometry},
    fruit::Fruit,
    kinect::RegisteredDepth,
    locate::{Camera, Here, Options, RegionSource, Searcher, locate_frame_with},
    region_view::{RegionView, ViewOptions, region_views},
    segment::{Regions, SegmentOptions, filter::gate_of_mean, hue::Gate, preset, regions::connected_regions},
};

/// A frame with the results of each of its stages, to run any stage by itself.
#[derive(Debug)]
pub struct Stages {
    frame: Frame,
    segment: SegmentOptions,
    gate: Gate,
    camera: Camera,
    regions: Regions,
    views: Vec<RegionView>,
}

impl Stages {
    /// Of a frame of jujubes.
    ///
    /// # Errors
    /// Those of the stages: none that a frame of [`workload::frame`] could cause.
    pub fn of(frame: Frame) -> Result<Self, InputError> {
        let segment = preset(Fruit::Jujube.name());
        let gate = Gate::new(&segment.gate)?;
        let camera = Camera::of(&frame)?;
        let mask = gate_of_mean(&frame.colour, segment.mean_radius_px, &gate);
        let regions = connected_regions(&mask, segment.area);
        let options = ViewOptions::of(&workload::default_search());
        let views = region_views(&camera.view(&frame), &regions, &options)?;
        Ok(Self { frame, segment, gate, camera, regions, views })
    }

    /// Regions of fruit colour.
    pub fn regions(&self) -> usize {
        self.regions.list.len()
    }

    /// Points behind them.
    pub fn points(&self) -> usize {
        self.views.iter().map(|view| view.points.len()).sum()
    }

    fn options(&self) -> Options {
        Options::new(workload::default_search(), RegionSource::Colour(self.segment), 1)
    }

    /// The whole way, the first contender, and each stage.
    pub fn contenders(&self) -> Vec<Contender<'_>> {
        let mask = gate_of_mean(&self.frame.colour, self.segment.mean_radius_px, &self.gate);
        let options = self.options();
        let mut contenders = vec![
            self.whole("whole frame"),
            Contender::new("mean filter and hue gate", || {
                black_box(gate_of_mean(&self.frame.colour, self.segment.mean_radius_px, &self.gate));
                1
            }),
            Contender::new("connected regions", move || {
                black_box(connected_regions(&mask, self.segment.area));
                1
            }),
            Contender::new("back-projection", || {
                let options = ViewOptions::of(&workload::default_search());
                black_box(region_views(&self.camera.view(&self.frame), &self.regions, &options))
                    .is_ok()
                    .into()
            }),
            Contender::new("search of all regions", move || {
                black_box(Here.search(&self.views, &options)).is_ok().into()
            }),
        ];
        if let Some(registration) = self.registration() {
            contenders.insert(1, registration);
        }
        contenders
    }

    /// Registration into the memory of the frame before.
    fn registration(&self) -> Option<Contender<'_>> {
        let (Camera::Kinect(pair), Geometry::Factory(_)) = (&self.camera, &self.frame.geometry) else {
            return None;
        };
        let registration = &pair.0;
        let mut registered: RegisteredDepth = pair.1.clone();
        let again = move || registration.register_again(&self.frame.depth_mm, &mut registered).is_ok().into();
        Some(Contender::new("depth-to-colour registration", again))
    }

    /// The whole way with the default search, frame after frame of one camera.
    pub fn whole(&self, name: &'static str) -> Contender<'_> {
        let (options, mut camera) = (self.options(), None);
        Contender::new(name, move || {
            black_box(locate_frame_with(&mut Here, &mut camera, "frame", &self.frame, &options))
                .is_ok()
                .into()
        })
    }
}
