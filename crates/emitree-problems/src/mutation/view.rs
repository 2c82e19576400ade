//! Views that may contain nothing, everything or the inside of a body.

use super::Mutator;
use core::f64::consts::FRAC_PI_2;
use core::fmt::Write;

const EMISSIONS: [&str; 7] = [
    "1",
    "0",
    "exp(-(x^2+y^2+z^2))",
    "exp(-8*((x-1)^2+y^2+z^2)) + 0.01*exp(-(x^2+y^2+z^2)/9)",
    "if(x > 0.3, 1, 0)*exp(-r)",
    "1/(0.1 + r^2)",
    "exp(-r)*(1 + 0.5*dx)",
];
const METHODS: [&str; 6] = ["vol", "vol", "vol", "vol", "paper", "los"];

impl Mutator {
    /// A scene of a random emission and a random camera, with or without bounds, bodies, edges,
    /// singularities, seeds and energies. Its image has a few pixels, and its budget is a few thousand evaluations at most.
    pub fn view(&mut self) -> String {
        let mut scene = String::new();
        let emission = self.choice(&EMISSIONS).copied().unwrap_or_default();
        // What is written to a string is always written.
        let _ = writeln!(scene, "[emission]\nexpression = \"{emission}\"\n");
        let _ = writeln!(scene, "{}", self.camera());
        if self.one_in(2) {
            let _ = writeln!(scene, "[bounds]\n{}", self.shape(true));
        }
        while self.one_in(2) {
            let _ = writeln!(scene, "[[occulter]]\n{}", self.shape(false));
        }
        while self.one_in(4) {
            let _ = writeln!(scene, "[[edge]]\n{}", self.edge());
        }
        while self.one_in(5) {
            let _ = writeln!(scene, "[[singularity]]\n{}", self.singularity());
        }
        if self.one_in(5) {
            let place = self.place(3.0);
            let radius = self.random.log_between(1e-3, 10.0);
            let _ = writeln!(scene, "[[seed]]\nposition = {place}\nradius = {radius:e}\n");
        }
        if self.one_in(6) {
            let bins = self.random.whole(1..=40);
            let _ = writeln!(scene, "[energy]\nmin = 0.5\nmax = 8.0\nbins = {bins}\n");
        }
        let method = self.choice(&METHODS).copied().unwrap_or_default();
        let tolerance = self.random.log_between(1e-4, 0.3);
        let budget = self.random.log_between(30.0, 5000.0).round();
        let _ = writeln!(
            scene,
            "[render]\nmethod = \"{method}\"\ntolerance = {tolerance:e}\nmax_evaluations = {budget}"
        );
        scene
    }

    /// The tables of a camera and of its image.
    fn camera(&mut self) -> String {
        let kind = self.random.whole(0..=6);
        let [width, height] = [1, 1].map(|least| self.random.whole(least..=20));
        let image = format!("[image]\nwidth = {width}\nheight = {height}\n");
        if kind == 0 {
            return format!("[projection]\ntype = \"canonical\"\n\n{image}");
        }
        let position = self.place(30.0);
        let near = if self.one_in(3) { self.random.between(0.0, 20.0) } else { 0.0 };
        let far =
            if self.one_in(3) { "inf".to_owned() } else { format!("{:e}", near + self.size()) };
        if kind == 6 {
            let nside = 1 << self.random.whole(0..=1);
            return format!(
                "[projection]\ntype = \"healpix\"\nposition = {position}\nnear = {near:e}\nfar = {far}\n\n\
                 [image]\nnside = {nside}\n"
            );
        }
        let angle = |mutator: &mut Self, most: f64| {
            if mutator.one_in(4) {
                mutator.random.log_between(1e-9, most)
            } else {
                mutator.random.between(1.0, most)
            }
        };
        let (name, field) = match kind {
            1 => ("orthographic", format!("extent = [{:e}, {:e}]", self.size(), self.size())),
            2 => (
                "perspective",
                format!("field_of_view = [{:e}, {:e}]", angle(self, 165.0), angle(self, 165.0)),
            ),
            3 => (
                "equirectangular",
                format!("field_of_view = [{:e}, {:e}]", angle(self, 360.0), angle(self, 180.0)),
            ),
            4 => ("polar", format!("field_of_view = {:e}", angle(self, 360.0))),
            _ => ("fisheye", format!("field_of_view = {:e}", angle(self, 360.0))),
        };
        let target = self.place(3.0);
        format!(
            "[projection]\ntype = \"{name}\"\nposition = {position}\ntarget = {target}\n{field}\n\
             near = {near:e}\nfar = {far}\n\n{image}"
        )
    }

    /// The keys of a shape; a box only if it `may_be_box`.
    fn shape(&mut self, may_be_box: bool) -> String {
        let center = self.place(6.0);
        match self.random.whole(if may_be_box { 0..=2 } else { 1..=2 }) {
            0 => {
                let [low, high] =
                    [(); 2].map(|()| [(); 3].map(|()| self.random.between(-9.0, 9.0)));
                let ends =
                    [0, 1, 2].map(|axis| [low[axis].min(high[axis]), low[axis].max(high[axis])]);
                let [min, max] = [0, 1].map(|end| ends.map(|of_axis| of_axis[end]));
                format!("type = \"box\"\nmin = {min:?}\nmax = {max:?}\n")
            }
            1 => format!("type = \"sphere\"\ncenter = {center}\nradius = {:e}\n", self.size()),
            _ => {
                let semi_axes = [(); 3].map(|()| self.size());
                format!("type = \"ellipsoid\"\ncenter = {center}\nsemi_axes = {semi_axes:?}\n")
            }
        }
    }

    /// The keys of an edge.
    fn edge(&mut self) -> String {
        if self.one_in(2) {
            return self.shape(false);
        }
        let [position, normal] = [3.0, 1.0].map(|most| self.place(most));
        format!("type = \"plane\"\nposition = {position}\nnormal = {normal}\n")
    }

    /// The keys of a singularity, which the emission need not have.
    fn singularity(&mut self) -> String {
        let position = self.place(3.0);
        if self.one_in(2) {
            let direction = self.place(1.0);
            return format!("type = \"axis\"\nposition = {position}\ndirection = {direction}\n");
        }
        let exponent = self.random.between(0.0, 2.99);
        format!("type = \"point\"\nposition = {position}\nexponent = {exponent}\n")
    }

    /// A point at most so far away along each axis; often on an axis, sometimes the origin.
    fn place(&mut self, most: f64) -> String {
        let place = [(); 3].map(|()| {
            if self.one_in(3) {
                0.0
            } else {
                most * libm::sin(self.random.between(-FRAC_PI_2, FRAC_PI_2))
            }
        });
        format!("{place:?}")
    }

    /// A length: mostly near 1, now and then tiny or huge.
    fn size(&mut self) -> f64 {
        if self.one_in(5) {
            self.random.log_between(1e-12, 1e12)
        } else {
            self.random.log_between(0.1, 30.0)
        }
    }
}
